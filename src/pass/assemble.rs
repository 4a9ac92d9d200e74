//! Fields made of other fields, sample by sample, or of their neighbours.

use crate::scene::Normals;

/// A surface that folds has no slope: where the mapping squeezes to less than this, it counts as this.
const LEAST_JACOBIAN: f32 = 0.1;

/// Jacobian of the horizontal mapping: (1 + Dxx)(1 + Dzz) - Dxz^2.
pub fn jacobian([dxx, dzz, dxz]: [&[f32]; 3], jacobian: &mut [f32]) {
    for (((j, dxx), dzz), dxz) in jacobian.iter_mut().zip(dxx).zip(dzz).zip(dxz) {
        *j = (1.0 + dxx) * (1.0 + dzz) - dxz * dxz;
    }
}

/// Smaller eigenvalue of the horizontal mapping (1 + Dxx, Dxz; Dxz, 1 + Dzz).
pub fn eigenvalue([dxx, dzz, dxz]: [&[f32]; 3], eigenvalue: &mut [f32]) {
    for (((e, dxx), dzz), dxz) in eigenvalue.iter_mut().zip(dxx).zip(dzz).zip(dxz) {
        let (mean, apart) = (0.5 * (dxx + dzz), 0.5 * (dxx - dzz));
        *e = 1.0 + mean - (apart * apart + dxz * dxz).sqrt();
    }
}

/// Slopes of the displaced surface as seen from the world, out of slopes (h_x, h_z) and derivatives at rest: the normal
/// is (-s_x, 1, -s_z). Without the mixed derivative where `diagonal`.
pub fn displaced_slopes(
    diagonal: bool,
    [hx, hz]: [&[f32]; 2],
    [dxx, dzz, dxz]: [&[f32]; 3],
    [sx, sz]: [&mut [f32]; 2],
) {
    for (i, (sx, sz)) in sx.iter_mut().zip(sz).enumerate() {
        (*sx, *sz) = match diagonal {
            true => ((hx[i] / (1.0 + dxx[i]).max(LEAST_JACOBIAN)), (hz[i] / (1.0 + dzz[i]).max(LEAST_JACOBIAN))),
            false => seen(hx[i], hz[i], [dxx[i], dxz[i], dxz[i], dzz[i]]),
        };
    }
}

/// The same out of displaced points (Dx, height, Dz) `spacing` metres apart at rest, by central differences or Sobel's
/// kernel: the mean of those over three neighbouring lines, weighted 1, 2, 1.
pub fn slopes_of_points(
    kernel: Normals,
    n: usize,
    spacing: f32,
    [dx, height, dz]: [&[f32]; 3],
    [sx, sz]: [&mut [f32]; 2],
) {
    let side = if kernel == Normals::Sobel { 0.25 } else { 0.0 };
    let (middle, scale) = (1.0 - 2.0 * side, 0.5 / spacing);
    let rows = sx.chunks_exact_mut(n).zip(sz.chunks_exact_mut(n)).enumerate();
    for (z, (sx, sz)) in rows {
        let lines = [(z + n - 1) % n, z, (z + 1) % n].map(|z| z * n..z * n + n);
        // Derivatives along x and z of one plane at column x, of whose neighbours are l and r.
        let differences = |plane: &[f32], l: usize, x: usize, r: usize| {
            let [above, here, below] = [&plane[lines[0].clone()], &plane[lines[1].clone()], &plane[lines[2].clone()]];
            let across = |line: &[f32]| line[r] - line[l];
            let down = |x: usize| below[x] - above[x];
            (
                scale * (middle * across(here) + side * (across(above) + across(below))),
                scale * (middle * down(x) + side * (down(l) + down(r))),
            )
        };
        let mut one = |l: usize, x: usize, r: usize| {
            let ((hx, hz), (xx, xz), (zx, zz)) =
                (differences(height, l, x, r), differences(dx, l, x, r), differences(dz, l, x, r));
            (sx[x], sz[x]) = seen(hx, hz, [xx, xz, zx, zz]);
        };
        one(n - 1, 0, 1);
        (1..n - 1).for_each(|x| one(x - 1, x, x + 1));
        one(n - 2, n - 1, 0);
    }
}

/// Slopes seen from the world where the mapping's derivatives are d Dx/dx, d Dx/dz, d Dz/dx, d Dz/dz.
fn seen(hx: f32, hz: f32, [xx, xz, zx, zz]: [f32; 4]) -> (f32, f32) {
    let jacobian = (1.0 + xx) * (1.0 + zz) - xz * zx;
    let inverse = 1.0 / jacobian.max(LEAST_JACOBIAN);
    ((hx * (1.0 + zz) - hz * zx) * inverse, (hz * (1.0 + xx) - hx * xz) * inverse)
}
