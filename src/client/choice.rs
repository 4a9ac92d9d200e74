//! What a client asks for, as options of a command line: a rate, a class, groups, cascades, a level and a codec.

use clap::Args;

use crate::wire::{Codec, ErrorClass, Group, Hello, HelloCascade, UnitName};

/// What a client asks for.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Choice {
    /// Frames a second; the server says which it has [default: its lowest]
    #[arg(long)]
    pub rate: Option<u32>,
    /// Error class: 0.5mm, 1mm, 5mm or 20mm
    #[arg(long, default_value = "1mm", value_parser = class)]
    pub class: ErrorClass,
    /// Groups of channels, separated by commas; those that the scene lacks are left out
    #[arg(long, default_value = "displacement,slopes,derivatives,foam", value_delimiter = ',', value_parser = group)]
    pub groups: Vec<Group>,
    /// Cascades, those of the longest waves first: a number or all
    #[arg(long, default_value = "all", value_parser = cascades)]
    pub cascades: usize,
    /// Level of detail; 0 is the full grid
    #[arg(long, default_value_t = 0)]
    pub level: u8,
    /// How samples are written: i16, rans, deflate, f16 or f32
    #[arg(long, default_value = "rans", value_parser = codec)]
    pub codec: Codec,
}

impl Choice {
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
        self.rate.or_else(|| hello.rates_hz.iter().min().copied())
    }
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

/// Reads how many cascades.
///
/// # Errors
/// Says what it must be.
pub fn cascades(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number: &usize| *number > 0);
    let all = (text == "all").then_some(usize::MAX);
    all.or(number).ok_or_else(|| "must be a number above 0, or all".to_owned())
}
