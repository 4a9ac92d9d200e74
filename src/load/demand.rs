//! What each client asks of the server: a rate, a class, groups, cascades and a level; alike, or mixed by shares.

use crate::wire::{Codec, ErrorClass, Group, Hello, HelloCascade, UnitName};

/// Golden ratio less one: its multiples spread evenly, so that any few clients have the mix of all.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// What one client asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// Its share among the demands of a mix; any positive number.
    pub share: f64,
    /// Frames a second; `None`: the lowest that the server has.
    pub rate_hz: Option<u32>,
    /// Error class.
    pub class: ErrorClass,
    /// Groups of channels.
    pub groups: Vec<Group>,
    /// Most cascades, those of the longest waves first.
    pub cascades: usize,
    /// Level of detail.
    pub level: u8,
    /// How samples are written.
    pub codec: Codec,
}

impl Demand {
    /// Its units of the sea that `hello` describes: of each group and cascade that the server has, no finer than it has
    /// them, and no more than it gives to one client.
    pub fn units(&self, hello: &Hello) -> Vec<UnitName> {
        let unit = |cascade: &HelloCascade, group: Group| {
            let detail = cascade.detail.iter().find(|detail| detail.group == group);
            let finest = detail.map_or(0, |detail| detail.finest_level);
            let coarsest = cascade.levels.saturating_sub(1);
            let had = detail.is_none_or(|detail| detail.rate_hz != Some(0));
            let level = self.level.min(coarsest).max(finest);
            had.then_some(UnitName { cascade: cascade.index, level, class: self.class, group, codec: self.codec })
        };
        let known = self.groups.iter().filter(|group| hello.groups.iter().any(|info| info.name == **group));
        let cascades = || hello.layout.cascades.iter().take(self.cascades);
        let units = known.flat_map(|group| cascades().filter_map(|cascade| unit(cascade, *group)));
        units.take(hello.limits.units as usize).collect()
    }

    /// The rate asked for, or the server's lowest.
    pub fn rate_hz(&self, hello: &Hello) -> Option<u32> {
        self.rate_hz.or_else(|| hello.rates_hz.iter().min().copied())
    }
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

/// Reads the name of an error class.
///
/// # Errors
/// Says which there are.
pub fn class(name: &str) -> Result<ErrorClass, String> {
    let names = ErrorClass::ALL.map(ErrorClass::name);
    ErrorClass::ALL.into_iter().find(|c| c.name() == name).ok_or_else(|| format!("must be one of {}", names.join(", ")))
}

/// Reads the name of a codec.
///
/// # Errors
/// Says which there are.
pub fn codec(name: &str) -> Result<Codec, String> {
    let names = Codec::ALL.map(Codec::name);
    Codec::ALL.into_iter().find(|c| c.name() == name).ok_or_else(|| format!("must be one of {}", names.join(", ")))
}

/// Reads the name of a group.
///
/// # Errors
/// Says which there are.
pub fn group(name: &str) -> Result<Group, String> {
    let names = Group::ALL.map(Group::name);
    Group::ALL.into_iter().find(|g| g.name() == name).ok_or_else(|| format!("must be one of {}", names.join(", ")))
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
