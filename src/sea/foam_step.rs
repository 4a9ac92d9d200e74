//! One step of the foam recursion, f <- max(d f, r source(J)): the only place where it is written.
//!
//! r grows while the water goes on breaking. Only such a form has a finite memory: every server that has run it long
//! enough holds the same bits, whenever it began.

use crate::scene::Foam;

/// What is remembered of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldFoam {
    /// Foam, 0 to 1.
    pub foam: f32,
    /// Share of its growth made by water that breaks, 0 to 1; 0 where it doesn't.
    pub growth: f32,
}

impl HeldFoam {
    /// The step from here, by water of this Jacobian: `decay` and `growth` are the shares of foam left and of growth
    /// made since. Foam below a five-hundredth is none.
    #[inline]
    pub fn step(self, jacobian: f32, threshold: f32, decay: f32, growth: f32) -> Self {
        const STEEPNESS: f32 = (1.0 / Foam::SOURCE_WIDTH) as f32;
        const FLUSH: f32 = Foam::FLUSH as f32;
        let source = ((threshold - jacobian) * STEEPNESS).clamp(0.0, 1.0);
        let growth = if source > 0.0 { (self.growth + growth).min(1.0) } else { 0.0 };
        let foam = (decay * self.foam).max(source * growth);
        Self { foam: if foam < FLUSH { 0.0 } else { foam }, growth }
    }
}
