// Fields made of other fields, sample by sample: twin of pass/assemble.rs.

// A surface that folds has no slope: where the mapping squeezes to less than this, it counts as this.
const LEAST_JACOBIAN: f32 = 0.1;

// Of the strain (Dxx, Dzz, Dxz).
fn determinant(strain: vec3<f32>) -> f32 {
    return (1.0 + strain.x) * (1.0 + strain.y) - strain.z * strain.z;
}

fn smaller_eigenvalue(strain: vec3<f32>) -> f32 {
    let mean = 0.5 * (strain.x + strain.y);
    let apart = 0.5 * (strain.x - strain.y);
    return 1.0 + mean - sqrt(apart * apart + strain.z * strain.z);
}

// Slopes seen from the world where the mapping's derivatives are d Dx/dx, d Dx/dz, d Dz/dx, d Dz/dz.
fn seen(slope: vec2<f32>, xx: f32, xz: f32, zx: f32, zz: f32) -> vec2<f32> {
    let jacobian = (1.0 + xx) * (1.0 + zz) - xz * zx;
    let inverse = 1.0 / max(jacobian, LEAST_JACOBIAN);
    return vec2<f32>(slope.x * (1.0 + zz) - slope.y * zx, slope.y * (1.0 + xx) - slope.x * xz) * inverse;
}

// The same without the mixed derivative.
fn seen_diagonal(slope: vec2<f32>, strain: vec3<f32>) -> vec2<f32> {
    return slope / max(1.0 + strain.xy, vec2<f32>(LEAST_JACOBIAN));
}
