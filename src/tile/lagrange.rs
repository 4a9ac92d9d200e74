//! Weights of frames in time: the polynomial through those around a moment.

/// Weights of values at `nodes` (different, relative to now) of the polynomial through them, now (Lagrange).
pub fn lagrange(nodes: &[f64]) -> Vec<f64> {
    let weight = |i: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, other)| other / (other - nodes[i])).product::<f64>()
    };
    (0..nodes.len()).map(weight).collect()
}
