//! Bounds of numbers people give, and the error that names field, value and bound.

use thiserror::Error;

/// Why a scene or a change is refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SceneError {
    /// A value outside what its field may hold.
    #[error("{field} is {value}, must be {bound}")]
    Bound {
        /// Path of the field in the scene file.
        field: String,
        /// The value found.
        value: String,
        /// What is allowed.
        bound: String,
    },
    /// Not of the form of a scene file.
    #[error("not a scene: {0}")]
    Form(String),
    /// A measured record that can't be read.
    #[error("measured: {0}")]
    Measured(#[from] super::NdbcError),
}

impl SceneError {
    /// An error for `field` holding `value`.
    pub fn bound(field: impl Into<String>, value: impl ToString, bound: impl Into<String>) -> Self {
        Self::Bound { field: field.into(), value: value.to_string(), bound: bound.into() }
    }

    /// The field at fault, where there is one.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Bound { field, .. } => Some(field),
            Self::Form(_) | Self::Measured(_) => None,
        }
    }
}

/// `value` when it is a number from `low` to `high`, with -0 made 0.
pub(crate) fn within(field: &str, value: f64, low: f64, high: f64) -> Result<f64, SceneError> {
    if value >= low && value <= high {
        Ok(value + 0.0)
    } else {
        Err(SceneError::bound(field, value, format!("a number from {low} to {high}")))
    }
}
