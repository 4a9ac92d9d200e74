//! Fields made of other fields, sample by sample, or of their neighbours.

use crate::scene::Normals;

/// A surface that folds has no slope: where the mapping squeezes to less than this, it counts as this.
const LEAST_JACOBIAN: f32 = 0.1;

/// Jacobian of the horizontal mapping (1 + Dxx, Dxz; Dxz, 1 + Dzz) where its strain is [Dxx, Dzz, Dxz].
#[inline(always)]
pub fn determinant([dxx, dzz, dxz]: [f32; 3]) -> f32 {
    (1.0 + dxx) * (1.0 + dzz) - dxz * dxz
}

/// The smaller eigenvalue of the same.
#[inline(always)]
pub fn smaller_eigenvalue([dxx, dzz, dxz]: [f32; 3]) -> f32 {
    let (mean, apart) = (0.5 * (dxx + dzz), 0.5 * (dxx - dzz));
    1.0 + mean - (apart * apart + dxz * dxz).sqrt()
}

/// Jacobians of a grid.
pub fn jacobian(strain: [&[f32]; 3], jacobian: &mut [f32]) {
    of_strain(strain, jacobian, determinant);
}

/// Smaller eigenvalues of a grid.
pub fn eigenvalue(strain: [&[f32]; 3], eigenvalue: &mut [f32]) {
    of_strain(strain, eigenvalue, smaller_eigenvalue);
}

fn of_strain([dxx, dzz, dxz]: [&[f32]; 3], made: &mut [f32], of: impl Fn([f32; 3]) -> f32) {
    for (((made, dxx), dzz), dxz) in made.iter_mut().zip(dxx).zip(dzz).zip(dxz) {
        *made = of([*dxx, *dzz, *dxz]);
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
pub fn slopes_of_points(kernel: Normals, n: usize, spacing: f32, points: [&[f32]; 3], [sx, sz]: [&mut [f32]; 2]) {
    let side = if kernel == Normals::Sobel { 0.25 } else { 0.0 };
    let weights = [1.0 - 2.0 * side, side].map(|weight| weight * 0.5 / spacing);
    // Derivatives along x and z of a line of each plane.
    let mut lines = [(); 3].map(|()| [vec![0.0; n], vec![0.0; n]]);
    for (z, (sx, sz)) in sx.chunks_exact_mut(n).zip(sz.chunks_exact_mut(n)).enumerate() {
        let rows = [(z + n - 1) % n, z, (z + 1) % n];
        for (plane, [across, down]) in points.iter().zip(&mut lines) {
            differences(weights, rows.map(|z| &plane[z * n..z * n + n]), across, down);
        }
        let [[xx, xz], [hx, hz], [zx, zz]] = &lines;
        for (x, (sx, sz)) in sx.iter_mut().zip(sz).enumerate() {
            (*sx, *sz) = seen(hx[x], hz[x], [xx[x], xz[x], zx[x], zz[x]]);
        }
    }
}

/// Differences along a line and down through it, of its own samples and, by the weight of the side, of its neighbours.
fn differences(weights: [f32; 2], lines: [&[f32]; 3], across: &mut [f32], down: &mut [f32]) {
    let n = across.len();
    // The ends are neighbours of each other.
    for x in [0, n - 1] {
        let near = lines.map(|line| [(x + n - 1) % n, x, (x + 1) % n].map(|x| line[x]));
        (across[x], down[x]) = difference(weights, near);
    }
    // Slices of one length, so that many samples are worked on at once.
    let inner = n - 2;
    let [above, here, below] = lines.map(|line| [0, 1, 2].map(|from| &line[from..from + inner]));
    let (across, down) = (&mut across[1..=inner], &mut down[1..=inner]);
    for x in 0..inner {
        let above = [above[0][x], above[1][x], above[2][x]];
        let here = [here[0][x], here[1][x], here[2][x]];
        let below = [below[0][x], below[1][x], below[2][x]];
        (across[x], down[x]) = difference(weights, [above, here, below]);
    }
}

/// The two differences at a sample of which these lines are the neighbourhood.
#[inline(always)]
fn difference([middle, side]: [f32; 2], [above, here, below]: [[f32; 3]; 3]) -> (f32, f32) {
    (
        middle * (here[2] - here[0]) + side * ((above[2] - above[0]) + (below[2] - below[0])),
        middle * (below[1] - above[1]) + side * ((below[0] - above[0]) + (below[2] - above[2])),
    )
}

/// Slopes seen from the world where the mapping's derivatives are d Dx/dx, d Dx/dz, d Dz/dx, d Dz/dz.
fn seen(hx: f32, hz: f32, [xx, xz, zx, zz]: [f32; 4]) -> (f32, f32) {
    let jacobian = (1.0 + xx) * (1.0 + zz) - xz * zx;
    let inverse = 1.0 / jacobian.max(LEAST_JACOBIAN);
    ((hx * (1.0 + zz) - hz * zx) * inverse, (hz * (1.0 + xx) - hx * xz) * inverse)
}
