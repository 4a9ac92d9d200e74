//! Clients that leave and are replaced while the load runs: whose turn it is, and how many there were.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use serde::Serialize;
use tokio::sync::mpsc::{Sender, error::TrySendError};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::stage::Stage;

/// How long the last that were told to leave, and those who come for them, may take.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often it is looked whether they came.
const LOOK: Duration = Duration::from_millis(20);

/// Counts of one run.
#[derive(Debug, Default)]
pub struct Turnover {
    /// Clients that were told to leave.
    pub told: AtomicUsize,
    /// Clients that left, and had the server's answer to their close.
    pub left: AtomicUsize,
    /// Clients that came in their place and were granted their subscription.
    pub came: AtomicUsize,
}

/// The counts at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Churned {
    pub told: usize,
    pub left: usize,
    pub came: usize,
}

impl Turnover {
    /// The counts now.
    pub fn counts(&self) -> Churned {
        let [told, left, came] = [&self.told, &self.left, &self.came].map(|count| count.load(Relaxed));
        Churned { told, left, came }
    }

    /// Waits until there is a client again for each that was told to leave, but not for long.
    pub async fn complete(&self) {
        let complete = async {
            while self.counts().came < self.counts().told {
                sleep(LOOK).await;
            }
        };
        // Whether it was is in the counts.
        let _ = timeout(PATIENCE, complete).await;
    }
}

/// Tells one client after the other to leave, `per_second` of them, the one whose turn is longest ago first.
pub async fn churn(mut seats: VecDeque<Sender<()>>, per_second: f64, stage: Arc<Stage>) {
    let mut turns = interval(Duration::from_secs_f64(1.0 / per_second));
    turns.set_missed_tick_behavior(MissedTickBehavior::Burst);
    // The first is at once.
    turns.tick().await;
    loop {
        turns.tick().await;
        // Who ended by itself is not replaced: it did not stay.
        while let Some(seat) = seats.pop_front() {
            let told = seat.try_send(());
            if !matches!(told, Err(TrySendError::Closed(()))) {
                // One that has not even left since its last turn counts as told: so it is seen that it didn't.
                stage.turnover.told.fetch_add(1, Relaxed);
                seats.push_back(seat);
                break;
            }
        }
    }
}
