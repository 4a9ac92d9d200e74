//! Ready scenes, each a file of its own in `presets/`.

use super::{Scene, SceneFile};

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Names of the presets and their files' text, in the order a list shows them.
        pub const PRESETS: &[(&str, &str)] = &[$(($name, include_str!(concat!("presets/", $name, ".toml")))),*];
    };
}

presets! {
    "beaufort-1", "beaufort-2", "beaufort-3", "beaufort-4", "beaufort-5",
    "beaufort-6", "beaufort-7", "beaufort-8", "beaufort-9", "beaufort-10",
    "ulsan-calm", "ulsan-medium", "ulsan-rough", "swell-and-wind-sea", "ndbc-41010",
    "long-swell", "shallow-bay", "hurricane", "pierson-moskowitz", "elfouhaily", "phillips", "ochi-hubble",
    "ndbc-41010-replay", "trochoid",
}

/// The preset of this name.
///
/// # Panics
/// Never: a test checks every preset's file.
pub fn preset(name: &str) -> Option<Scene> {
    let (_, text) = PRESETS.iter().find(|(known, _)| *known == name)?;
    Some(SceneFile::from_toml(text).and_then(|file| file.check(None)).expect("presets are checked by a test"))
}
