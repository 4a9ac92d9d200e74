//! Bytes that a frame must move at least, counted from its plan.

use super::bundle::BUNDLES;
use super::settings::Storage;
use crate::plan::{Packing, Plan};
use crate::sea::Layout;

/// Bytes read and written, by pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Tables of modes read, columns written.
    pub columns: u64,
    /// Columns read, samples written.
    pub rows: u64,
    /// Jacobians and held foam read, held and shown foam written.
    pub foam: u64,
    /// Samples read, counts written.
    pub quantise: u64,
}

impl Traffic {
    /// All of it.
    pub fn total(self) -> u64 {
        self.columns + self.rows + self.foam + self.quantise
    }
}

/// What a plan moves where everything is read and written once, and nothing stays in a cache.
pub fn traffic(plan: &Plan, layout: &Layout, storage: Storage) -> Traffic {
    let stored: u64 = if storage == Storage::F16 { 4 } else { 8 };
    let mut all = Traffic::default();
    for (plan, cascade) in plan.cascades.iter().zip(&layout.cascades) {
        for level in &plan.levels {
            let (n, half) = cascade.level(level.level);
            let (n, half) = (n as u64, half as u64);
            for work in BUNDLES.iter().filter_map(|bundle| Some((bundle, bundle.work(level)?))) {
                let (bundle, work) = work;
                let columns: u64 = bundle
                    .slots
                    .iter()
                    .zip(work.made)
                    .filter(|(_, made)| *made)
                    .map(|(slot, _)| if matches!(slot, Some(Packing::Packed(..))) { 2 * half + 1 } else { half + 1 })
                    .sum();
                if columns > 0 {
                    all.columns += (half + 1) * (2 * half + 1) * 32;
                }
                all.columns += columns * n * stored;
                all.rows += columns * n * stored + work.planes() * n * n * 4;
            }
        }
        let samples = (cascade.n * cascade.n) as u64;
        if let Some(foam) = plan.foam {
            all.foam += samples * (4 + 8 + 4 * u64::from(foam.breaks) + 8 * u64::from(foam.advance));
        }
        for counted in plan.wanted.iter().flat_map(|wanted| &wanted.counts) {
            let made = samples >> (2 * counted.level);
            let read = if counted.field == crate::plan::Field::Foam { samples } else { made };
            all.quantise += read * 4 + made * 2;
        }
    }
    all
}
