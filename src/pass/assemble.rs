//! Fields made of other fields, sample by sample.

/// Jacobian of the horizontal mapping: (1 + Dxx)(1 + Dzz) - Dxz^2. Missing derivatives (no choppiness) give 1.
pub fn jacobian(dxx: &[f32], dzz: &[f32], dxz: &[f32], jacobian: &mut [f32]) {
    for (((j, dxx), dzz), dxz) in jacobian.iter_mut().zip(dxx).zip(dzz).zip(dxz) {
        *j = (1.0 + dxx) * (1.0 + dzz) - dxz * dxz;
    }
}
