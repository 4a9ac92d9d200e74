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
    let smooth = kernel == Normals::Sobel;
    let mut of = [(); 3].map(|()| Differences::new(n));
    for (z, (sx, sz)) in sx.chunks_exact_mut(n).zip(sz.chunks_exact_mut(n)).enumerate() {
        for (of, plane) in of.iter_mut().zip([height, dx, dz]) {
            of.take(plane, z, smooth, 0.5 / spacing);
        }
        let [of_height, of_dx, of_dz] = &of;
        let (hx, hz, xx, xz) = (&of_height.x[..n], &of_height.z[..n], &of_dx.x[..n], &of_dx.z[..n]);
        let (zx, zz, sz) = (&of_dz.x[..n], &of_dz.z[..n], &mut sz[..n]);
        for x in 0..n {
            (sx[x], sz[x]) = seen(hx[x], hz[x], [xx[x], xz[x], zx[x], zz[x]]);
        }
    }
}

/// Derivatives of one row of a plane, and rows that they are made in, with a neighbour on each side.
struct Differences {
    x: Vec<f32>,
    z: Vec<f32>,
    here: Vec<f32>,
    across: Vec<f32>,
}

impl Differences {
    fn new(n: usize) -> Self {
        let row = |n: usize| vec![0.0; n];
        Self { x: row(n), z: row(n), here: row(n + 2), across: row(n + 2) }
    }

    fn take(&mut self, plane: &[f32], z: usize, smooth: bool, scale: f32) {
        let n = self.x.len();
        let row = |z: usize| &plane[z % n * n..][..n];
        let (above, row, below) = (row(z + n - 1), row(z), row(z + 1));
        let (here, across) = (&mut self.here[1..=n], &mut self.across[1..=n]);
        for x in 0..n {
            here[x] = if smooth { 0.5 * row[x] + 0.25 * (above[x] + below[x]) } else { row[x] };
            across[x] = below[x] - above[x];
        }
        for padded in [&mut self.here, &mut self.across] {
            (padded[0], padded[n + 1]) = (padded[n], padded[1]);
        }
        let (left, right) = (&self.here[..n], &self.here[2..][..n]);
        for ((x, left), right) in self.x.iter_mut().zip(left).zip(right) {
            *x = scale * (right - left);
        }
        let (left, middle, right) = (&self.across[..n], &self.across[1..][..n], &self.across[2..][..n]);
        for (x, z) in self.z[..n].iter_mut().enumerate() {
            *z = scale * if smooth { 0.5 * middle[x] + 0.25 * (left[x] + right[x]) } else { middle[x] };
        }
    }
}

/// Slopes seen from the world where the mapping's derivatives are d Dx/dx, d Dx/dz, d Dz/dx, d Dz/dz.
fn seen(hx: f32, hz: f32, [xx, xz, zx, zz]: [f32; 4]) -> (f32, f32) {
    let jacobian = (1.0 + xx) * (1.0 + zz) - xz * zx;
    let inverse = 1.0 / jacobian.max(LEAST_JACOBIAN);
    ((hx * (1.0 + zz) - hz * zx) * inverse, (hz * (1.0 + xx) - hx * xz) * inverse)
}
