//! Scene files: a text is refused, or it is a scene that is written back to itself.
#![no_main]

use libfuzzer_sys::fuzz_target;
use swellcast::scene::{SceneError, SceneFile};

fuzz_target!(|text: &str| {
    let Ok(file) = SceneFile::from_toml(text) else { return };
    // Without a base folder no text makes it read a file.
    let scene = match file.check(None) {
        Ok(scene) => scene,
        Err(error) => {
            assert!(error.field().is_some() || matches!(error, SceneError::Measured(_)), "no field: {error}");
            return;
        }
    };
    let written = SceneFile::from(&scene);
    assert_eq!(written.clone().check(None).as_ref(), Ok(&scene), "from the form");
    let text = toml::to_string(&written).expect("a checked scene can be written");
    assert_eq!(SceneFile::from_toml(&text).as_ref(), Ok(&written), "from the text\n{text}");
});
