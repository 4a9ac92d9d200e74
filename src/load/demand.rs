//! What each client asks of the server: a rate, a class, groups, cascades and a level; alike, or mixed by shares.

use crate::client::{Choice, class, group};
use crate::wire::{ErrorClass, Group};

/// Golden ratio less one: its multiples spread evenly, so that any few clients have the mix of all.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// What some of the clients ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// Their share among the demands of a mix; any positive number.
    pub share: f64,
    /// What each of them asks for.
    pub choice: Choice,
}

/// Which of the demands the client of a number has: each as often as its share says.
pub fn demand_of(demands: &[Demand], client: usize) -> usize {
    let total: f64 = demands.iter().map(|demand| demand.share).sum();
    // The first client of each demand comes first: a server that makes them all is what the others are measured on.
    if client < demands.len() {
        return client;
    }
    let mut at = (client as f64 * GOLDEN).fract() * total;
    let place = demands.iter().position(|demand| {
        at -= demand.share;
        at < 0.0
    });
    place.unwrap_or(demands.len() - 1)
}

/// One part of a mix: `SHARE:RATE:CLASS:GROUPS`, as in `30:60:1mm:displacement,slopes`.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its share; any positive number.
    pub share: f64,
    /// Frames a second.
    pub rate_hz: u32,
    /// Error class.
    pub class: ErrorClass,
    /// Groups of channels.
    pub groups: Vec<Group>,
}

impl std::str::FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fields: Vec<&str> = text.split(':').collect();
        let [share, rate, class_name, groups] = fields[..] else {
            return Err("must be SHARE:RATE:CLASS:GROUPS, as in 30:60:1mm:displacement,slopes".to_owned());
        };
        let share = share.parse().ok().filter(|share: &f64| share.is_finite() && *share > 0.0);
        let share = share.ok_or("SHARE must be a number above 0")?;
        let rate_hz = rate.parse().map_err(|_| "RATE must be a whole number")?;
        let groups = groups.split(',').map(group).collect::<Result<_, _>>()?;
        Ok(Self { share, rate_hz, class: class(class_name)?, groups })
    }
}
