//! Which particle has come to a point: the inverse of the horizontal displacement, by damped Newton.

/// Distance that counts as arrived, metres.
const ARRIVED_M: f64 = 1e-4;
const MAX_ITERATIONS: u32 = 100;
/// A step cut to this is no step: the search stands at a fold.
const LEAST_STEP: f64 = 0.1;
/// Between starts, radians: no two lie in line.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// Between this Jacobian and its opposite Newton's steps lead anywhere.
const WELL_BEHAVED: f64 = 1e-3;

/// Horizontal displacement of the particle that rests at a point, and how that changes with the point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// Along x, metres.
    pub dx: f64,
    /// Along z, metres.
    pub dz: f64,
    /// d dx / dx.
    pub dxx: f64,
    /// d dz / dz.
    pub dzz: f64,
    /// d dx / dz.
    pub dxz: f64,
    /// d dz / dx: the same in the sea, nearly the same between samples of it.
    pub dzx: f64,
}

impl Displacement {
    /// Determinant of the horizontal mapping; 0 and below where it folds.
    pub fn jacobian(&self) -> f64 {
        (1.0 + self.dxx) * (1.0 + self.dzz) - self.dxz * self.dzx
    }
}

/// The particle that was looked for, or the nearest to it that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestPosition {
    /// Where it rests, metres.
    pub at: [f64; 2],
    /// How far it is, displaced, from the point it should have come to, metres.
    pub residual: f64,
    /// Steps that were taken.
    pub iterations: u32,
    /// Whether the residual is below a tenth of a millimetre.
    pub arrived: bool,
    /// Determinant of the horizontal mapping there.
    pub jacobian: f64,
}

impl RestPosition {
    /// Whether the surface folds here: other sheets may lie above the one found, or none was found.
    pub fn folded(&self) -> bool {
        // Also for a Jacobian that is no number.
        !(self.arrived && self.jacobian > 0.0)
    }
}

/// One place that was looked at.
#[derive(Clone, Copy)]
struct Place {
    /// From the point wanted; small numbers, however far out that lies.
    offset: [f64; 2],
    /// What is missing to the point wanted.
    rest: [f64; 2],
    residual: f64,
    displacement: Displacement,
}

/// The rest position x0 with x0 + D(x0) = `target`, metres, where `displacement` gives D.
///
/// Newton's method, each step cut until it brings the particle nearer. Where that ends short of the point, at a fold,
/// it begins again farther and farther around; of all places the nearest counts.
pub fn rest_position(target: [f64; 2], displacement: impl FnMut([f64; 2]) -> Displacement) -> RestPosition {
    rest_position_within(MAX_ITERATIONS, target, displacement)
}

/// The same in so many steps at most: what has not arrived by then is told as it stands.
pub fn rest_position_within(
    most: u32,
    target: [f64; 2],
    mut displacement: impl FnMut([f64; 2]) -> Displacement,
) -> RestPosition {
    let mut look = |offset: [f64; 2]| {
        let displacement = displacement([target[0] + offset[0], target[1] + offset[1]]);
        let rest = [-offset[0] - displacement.dx, -offset[1] - displacement.dz];
        Place { offset, rest, residual: (rest[0] * rest[0] + rest[1] * rest[1]).sqrt(), displacement }
    };
    let first = look([0.0; 2]);
    let (mut best, mut here, mut share, mut starts, mut iterations) = (first, first, 1.0, 0, 0);
    // Upside down, plain steps lead out to where the surface is not; only where they don't, Newton's lead on.
    let mut plainly = true;
    while best.residual > ARRIVED_M && iterations < most.min(MAX_ITERATIONS) {
        iterations += 1;
        if share >= LEAST_STEP {
            let step = here.step(plainly);
            let next = look([here.offset[0] + share * step[0], here.offset[1] + share * step[1]]);
            (here, share) = if next.residual < here.residual { (next, 1.0) } else { (here, 0.5 * share) };
        } else if plainly && here.displacement.jacobian() < -WELL_BEHAVED {
            (plainly, share) = (false, 1.0);
        } else {
            // What is looked for lies about as far away as particles move.
            starts += 1;
            let (radius, angle) = (0.6 * first.residual * f64::from(starts).sqrt(), GOLDEN_ANGLE * f64::from(starts));
            (here, share, plainly) = (look([radius * libm::cos(angle), radius * libm::sin(angle)]), 1.0, true);
        }
        if here.residual < best.residual {
            best = here;
        }
    }
    let Place { offset, residual, displacement, .. } = best;
    RestPosition {
        at: [target[0] + offset[0], target[1] + offset[1]],
        residual,
        iterations,
        arrived: residual <= ARRIVED_M,
        jacobian: displacement.jacobian(),
    }
}

impl Place {
    /// Newton's step where the mapping is well behaved, else the plain one; upside down, whichever is wished.
    fn step(&self, plainly: bool) -> [f64; 2] {
        let ([x, z], Displacement { dxx, dzz, dxz, dzx, .. }) = (self.rest, self.displacement);
        let jacobian = self.displacement.jacobian();
        match jacobian > WELL_BEHAVED || !plainly && jacobian < -WELL_BEHAVED {
            true => [((1.0 + dzz) * x - dxz * z) / jacobian, ((1.0 + dxx) * z - dzx * x) / jacobian],
            false => [x, z],
        }
    }
}
