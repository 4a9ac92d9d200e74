//! What is computed of a sea: the effects that a scene calls for, and how fine and how often each may be had.

use serde::{Deserialize, Serialize};

use super::Foam;
use super::bound::SceneError;
use crate::wire::{Group, RATES_HZ};

/// Most entries of `[[detail]]`.
const MAX_DETAILS: usize = 64;

/// How normals come to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Normals {
    /// None.
    None,
    /// From the sums over cascades of five spectral channels: slopes and derivatives. No error.
    #[default]
    Exact,
    /// From the sums of four: h_x / (1 + D_xx) and h_z / (1 + D_zz), without the mixed derivative.
    Diagonal,
    /// Slopes of each cascade's displaced surface, from its five spectral channels; clients add them up.
    DisplacedSlopes,
    /// The same from central differences of its displaced points.
    CentralDifference,
    /// The same by Sobel's kernel.
    Sobel,
}

impl Normals {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Exact, Self::Diagonal, Self::DisplacedSlopes, Self::CentralDifference, Self::Sobel];

    /// The name in scene files.
    pub fn name(self) -> &'static str {
        ["none", "exact", "diagonal", "displaced-slopes", "central-difference", "sobel"][self as usize]
    }
}

/// What is computed of the sea. Height always is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects {
    /// Horizontal displacement: 0 none, 1 first-order Lagrangian.
    pub choppiness: f64,
    /// Derivatives of the height.
    pub slopes: bool,
    /// Normals, and in which way.
    pub normals: Normals,
    /// Jacobian and smaller eigenvalue of the horizontal mapping.
    pub jacobian: bool,
    /// Velocity of the water.
    pub velocity: bool,
    /// Foam, or none.
    pub foam: Option<Foam>,
}

impl Default for Effects {
    /// All of them.
    fn default() -> Self {
        Self {
            choppiness: 1.0,
            slopes: true,
            normals: Normals::default(),
            jacobian: true,
            velocity: true,
            foam: Some(Foam::default()),
        }
    }
}

impl Effects {
    /// Whether a scene with these effects has a group of channels.
    pub fn has(&self, group: Group) -> bool {
        match group {
            Group::Displacement | Group::Height => true,
            Group::Slopes => self.slopes,
            Group::Derivatives => self.normals == Normals::Exact,
            Group::Stretch => matches!(self.normals, Normals::Exact | Normals::Diagonal),
            Group::Normals => self.normals != Normals::None,
            Group::Jacobian => self.jacobian,
            Group::Velocity => self.velocity,
            Group::Foam => self.foam.is_some(),
        }
    }

    /// # Errors
    /// [`SceneError::Bound`] where normals need slopes that are switched off.
    pub(super) fn check(self) -> Result<Self, SceneError> {
        if !self.slopes && matches!(self.normals, Normals::Exact | Normals::Diagonal) {
            let bound = format!("true where effects.normals is {}", self.normals.name());
            return Err(SceneError::bound("effects.slopes", false, bound));
        }
        Ok(self)
    }
}

/// `[[detail]]`: what clients can have of one group of one cascade, at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detail {
    /// Place of the cascade in its layout, 0 the longest waves; places that a layout doesn't have mean nothing.
    pub cascade: u8,
    /// The group of channels.
    pub group: Group,
    /// The finest level, 0 the full grid.
    #[serde(default)]
    pub finest_level: u8,
    /// The highest rate, frames a second; 0: none at all. Absent: as high as any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<u32>,
}

impl Detail {
    /// # Errors
    /// [`SceneError::Bound`] for the first entry out of bounds, or that stands twice.
    pub(super) fn check(details: Vec<Self>) -> Result<Vec<Self>, SceneError> {
        if details.len() > MAX_DETAILS {
            let bound = format!("at most {MAX_DETAILS}");
            return Err(SceneError::bound("detail", format!("{} entries", details.len()), bound));
        }
        for (i, detail) in details.iter().enumerate() {
            let most = super::CascadeRequest::MAX_PATCHES as u8;
            if detail.cascade >= most {
                return Err(SceneError::bound(format!("detail[{i}].cascade"), detail.cascade, format!("below {most}")));
            }
            if detail.finest_level > 7 {
                return Err(SceneError::bound(format!("detail[{i}].finest_level"), detail.finest_level, "0 to 7"));
            }
            if let Some(rate) = detail.rate_hz.filter(|rate| *rate != 0 && !RATES_HZ.contains(rate)) {
                return Err(SceneError::bound(
                    format!("detail[{i}].rate_hz"),
                    rate,
                    format!("0 or one of {RATES_HZ:?}"),
                ));
            }
            if details[..i].iter().any(|d| (d.cascade, d.group) == (detail.cascade, detail.group)) {
                let value = format!("{} of cascade {} again", detail.group.name(), detail.cascade);
                return Err(SceneError::bound(format!("detail[{i}]"), value, "once for a group of a cascade"));
            }
        }
        Ok(details)
    }
}
