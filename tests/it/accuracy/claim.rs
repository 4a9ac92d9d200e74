//! What the server says that its stream errs is what a client finds that compares it with an export of the reference.

use std::collections::BTreeMap;
use std::io::Read;
use std::process::Command;

use serde_json::json;
use swellcast::server::Settings;
use swellcast::tile::{DecodedFrame, Decoder};

use crate::served::{SMALL, Served};
use crate::support::scene;

/// An array of an .npz, little-endian f32.
fn array(path: &std::path::Path, name: &str) -> Vec<f32> {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[head..].as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_claimed_of_a_stream_is_what_a_client_measures_beside_the_reference() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    let unit = |group, class| json!({ "cascade": 0, "level": 0, "class": class, "group": group, "codec": "rans" });
    let units = [unit("displacement", "5mm"), unit("slopes", "1mm")];
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 30, "units": units })).await;
    let (mut decoder, mut frames) = (Decoder::new(1 << 16), BTreeMap::<u64, Vec<DecodedFrame>>::new());
    while frames.len() < 20 {
        let decoded = decoder.decode(&client.frame().await).unwrap();
        frames.entry(decoded.header.tick).or_default().push(decoded);
    }
    // Predicted from others, so that their errors would show.
    let whole = frames.iter().rev().find(|(_, of_tick)| of_tick.len() == 2 && of_tick[0].header.depth > 0);
    let (tick, of_tick) = whole.expect("a tick of which both groups came");
    let told = served.get(&format!("/v1/scenes/small/accuracy?tick={tick}")).await;
    assert_eq!(told.status, 200, "{}", told.body);
    let told = told.json();
    assert_eq!(told["tick"], *tick);

    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("scene.toml"), folder.path().join("sea.npz"));
    std::fs::write(&file, SMALL).unwrap();
    let seconds = (*tick as f64 / 7200.0).to_string();
    let mut export = Command::new(env!("CARGO_BIN_EXE_swellcast"));
    export.args(["export", "--backend", "reference", "--time", &seconds, "--scene"]).arg(&file).arg("--out").arg(&out);
    assert!(export.status().unwrap().success());

    let mut compared = 0;
    for frame in of_tick {
        let group = frame.unit().group;
        for (name, plane) in group.channels().iter().zip(&frame.planes) {
            let truth = array(&out, &format!("c0_{name}"));
            let errors = || plane.iter().zip(&truth).map(|(a, b)| f64::from(*a) - f64::from(*b));
            let rms = (errors().map(|error| error * error).sum::<f64>() / truth.len() as f64).sqrt();
            let max = errors().fold(0.0_f64, |most, error| most.max(error.abs()));
            let claim = told["channels"]
                .as_array()
                .unwrap()
                .iter()
                .find(|claim| claim["channel"] == *name && claim["unit"]["group"] == group.name());
            let claim = claim.unwrap_or_else(|| panic!("{name} is not in {told}"));
            let said = |which: &str| claim[which].as_f64().unwrap();
            // The export is rounded to f32.
            assert!((said("rms") / rms - 1.0).abs() < 1e-4, "{name}: said {}, is {rms}", said("rms"));
            assert!((said("max") / max - 1.0).abs() < 1e-3, "{name}: said {}, is {max}", said("max"));
            assert!(max <= said("bound") && rms > 0.2 * said("bound"), "{name}: {rms} {max} {}", said("bound"));
            compared += 1;
        }
    }
    assert_eq!(compared, 5);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_asks_for_errors_is_told_of_all_groups_where_nobody_watches_and_of_no_tick_out_of_reach() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let told = served.get("/v1/scenes/small/accuracy").await.json();
    let channels = told["channels"].as_array().unwrap();
    assert!(channels.len() > 5, "{told}");
    for claim in channels {
        let (bound, foam) = (claim["bound"].as_f64().unwrap(), claim["unit"]["group"] == "foam");
        assert_eq!(claim["max"].is_null(), foam, "{claim}");
        assert!(claim["max"].as_f64().is_none_or(|max| max > 0.0 && max <= 1.001 * bound), "{claim}");
    }
    for (query, field) in [("tick=-1", "tick"), ("tick=900000000", "tick"), ("tick=x", "tick"), ("when=1", "when")] {
        let refused = served.get(&format!("/v1/scenes/small/accuracy?{query}")).await;
        assert_eq!((refused.status, refused.json()["field"].as_str()), (422, Some(field)), "{}", refused.body);
    }
    served.stop().await;
}
