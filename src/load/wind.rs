//! Changes the scene's wind over HTTP every so often, and sets it back as it was found.

use std::net::SocketAddr;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep};

use crate::client::exchange;

/// The two speeds, as parts of the one that was found.
const SPEEDS: [f64; 2] = [0.75, 1.3];
/// How far each change turns the direction, degrees: the wind goes round in nine changes.
const TURN_DEG: f64 = 40.0;
/// Longest that the sea takes to follow, seconds.
const TRANSITION_S: f64 = 5.0;
/// How often it is tried to set the wind back, and how long in between.
const ATTEMPTS: u32 = 5;
const AGAIN: Duration = Duration::from_secs(1);

/// The wind of a scene as it was found.
#[derive(Clone, Debug)]
pub struct Wind {
    address: SocketAddr,
    host: String,
    path: String,
    speed_mps: f64,
    direction_from_deg: f64,
    /// Speeds that the sea can follow.
    range_mps: [f64; 2],
}

/// What became of the changes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct WindChanges {
    /// The last is the one that set it back.
    pub accepted: u64,
    pub failed: u64,
    pub first_failure: Option<String>,
}

impl Wind {
    /// Asks the server what the wind of a scene is.
    ///
    /// # Errors
    /// When the server doesn't say, or the sea is not driven by wind.
    pub async fn find(address: SocketAddr, host: &str, scene: &str) -> Result<Self> {
        let path = format!("/v1/scenes/{scene}");
        let (status, body) = exchange(address, host, "GET", &path, "").await.context("asking for the wind")?;
        ensure!(status == 200, "asking for the wind: the server answers {status}: {}", words(&body));
        let body: Value = serde_json::from_str(&body).with_context(|| format!("{path} is no JSON"))?;
        let wind = &body["state"]["wind"];
        let range = &body["state"]["wind_range_mps"];
        let found = wind["speed_mps"].as_f64().zip(wind["direction_from_deg"].as_f64());
        let (speed_mps, direction_from_deg) =
            found.with_context(|| format!("wind-every needs a wind, but {scene:?} is not driven by one"))?;
        let range_mps = range[0].as_f64().zip(range[1].as_f64()).map_or([0.0, f64::INFINITY], <[f64; 2]>::from);
        Ok(Self { address, host: host.to_owned(), path: path + "/wind", speed_mps, direction_from_deg, range_mps })
    }

    /// Changes the wind every so many seconds until it is stopped, and then sets it back.
    pub async fn change(self, every_s: f64, mut stop: watch::Receiver<bool>) -> WindChanges {
        let transition_s = TRANSITION_S.min(every_s / 2.0);
        let mut changes = WindChanges::default();
        let mut beat = interval(Duration::from_secs_f64(every_s));
        beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        // The first is at once.
        beat.tick().await;
        for number in 0.. {
            tokio::select! {
                biased;
                // An error: whoever could stop us is gone.
                _ = stop.wait_for(|stop| *stop) => break,
                _ = beat.tick() => {}
            }
            let [low, high] = self.range_mps;
            let speed_mps = (self.speed_mps * SPEEDS[number % 2]).min(high).max(low);
            let direction_from_deg = (self.direction_from_deg + TURN_DEG * (number + 1) as f64) % 360.0;
            changes.count(self.put(speed_mps, direction_from_deg, transition_s).await);
        }
        if changes != WindChanges::default() {
            changes.count(self.set_back(transition_s).await);
        }
        changes
    }

    /// A server that refuses is asked again: what is not set back stays so for its operator.
    async fn set_back(&self, transition_s: f64) -> Result<()> {
        let mut set = self.put(self.speed_mps, self.direction_from_deg, transition_s).await;
        for _ in 1..ATTEMPTS {
            if set.is_err() {
                sleep(AGAIN).await;
                set = self.put(self.speed_mps, self.direction_from_deg, transition_s).await;
            }
        }
        set.context("setting the wind back")
    }

    async fn put(&self, speed_mps: f64, direction_from_deg: f64, transition_s: f64) -> Result<()> {
        let body = json!({
            "speed_mps": speed_mps, "direction_from_deg": direction_from_deg, "transition_s": transition_s,
        });
        let (status, body) = exchange(self.address, &self.host, "PUT", &self.path, &body.to_string()).await?;
        ensure!(status == 202, "the server answers {status}: {}", words(&body));
        Ok(())
    }
}

impl WindChanges {
    fn count(&mut self, changed: Result<()>) {
        match changed {
            Ok(()) => self.accepted += 1,
            Err(why) => {
                self.failed += 1;
                self.first_failure.get_or_insert_with(|| format!("{why:#}"));
            }
        }
    }
}

/// What a refusal says for people.
fn words(body: &str) -> String {
    let problem: Option<Value> = serde_json::from_str(body).ok();
    let detail = problem.as_ref().and_then(|problem| problem["detail"].as_str());
    detail.unwrap_or(body).trim().to_owned()
}
