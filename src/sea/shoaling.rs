//! What shallow water takes from a wind sea: the depth factor phi of TMA.

/// Kitaigorodskii's depth factor (Bouws et al. 1985, exact form) at the k d of a wave:
/// tanh^2(kd) / (1 + 2 kd / sinh(2 kd)).
pub fn kitaigorodskii(kd: f64) -> f64 {
    if kd >= 20.0 {
        return 1.0;
    }
    let tanh = libm::tanh(kd);
    // 2kd / sinh(2kd) tends to 1 in shallow water.
    let ratio = if kd < 1e-6 { 1.0 } else { 2.0 * kd / libm::sinh(2.0 * kd) };
    tanh * tanh / (1.0 + ratio)
}

/// The approximation of Thompson & Vincent (1983) at wh = w sqrt(d / g): two parabolas.
pub fn thompson_vincent(wh: f64) -> f64 {
    match wh {
        wh if wh <= 1.0 => 0.5 * wh * wh,
        wh if wh < 2.0 => 1.0 - 0.5 * (2.0 - wh) * (2.0 - wh),
        _ => 1.0,
    }
}
