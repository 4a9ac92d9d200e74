//! Points that stream clients follow: what each wants, and the newest message for each. Nothing is queued.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use bytes::Bytes;

use crate::engine::{PointsMessage, PointsWish};

/// All subscriptions of points.
#[derive(Debug)]
pub struct PointsBoard {
    most: usize,
    held: Mutex<BTreeMap<u64, Held>>,
}

#[derive(Debug)]
struct Held {
    wish: PointsWish,
    /// The first tick that was promised.
    first: i64,
    newest: Option<Bytes>,
}

impl PointsBoard {
    /// No wishes; at most `most` points for all clients together.
    pub fn new(most: usize) -> Self {
        Self { most, held: Mutex::default() }
    }

    fn held(&self) -> MutexGuard<'_, BTreeMap<u64, Held>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces a client's wish, one without points by none. `tell` gets the wishes of all, then `newest` says up to
    /// which tick messages may have left without it. Returns the first tick whose message will come.
    ///
    /// # Errors
    /// How many points are left for this client.
    pub fn replace(
        &self,
        wish: PointsWish,
        tell: impl FnOnce(Vec<PointsWish>),
        newest: impl FnOnce() -> i64,
    ) -> Result<i64, usize> {
        let mut held = self.held();
        let others = held.iter().filter(|(client, _)| **client != wish.client);
        let left = self.most.saturating_sub(others.map(|(_, held)| held.wish.points.len()).sum());
        if wish.points.len() > left {
            return Err(left);
        }
        let (client, interval) = (wish.client, wish.interval);
        let known = held.remove(&client).is_some();
        let wanted = !wish.points.is_empty();
        if wanted {
            held.insert(client, Held { wish, first: i64::MAX, newest: None });
        }
        if wanted || known {
            tell(held.values().map(|held| held.wish.clone()).collect());
        }
        let first = (newest() / interval + 1) * interval;
        if let Some(held) = held.get_mut(&client) {
            held.first = first;
        }
        Ok(first)
    }

    /// Forgets a client. `tell` gets the wishes of all others, if that changes anything.
    pub fn remove(&self, client: u64, tell: impl FnOnce(Vec<PointsWish>)) {
        let mut held = self.held();
        if held.remove(&client).is_some() {
            tell(held.values().map(|held| held.wish.clone()).collect());
        }
    }

    /// Takes over what the engine has made: the newest of each client alone is kept.
    pub fn post(&self, messages: Vec<PointsMessage>) {
        if messages.is_empty() {
            return;
        }
        let mut held = self.held();
        for PointsMessage { client, id, tick, bytes } in messages {
            if let Some(held) = held.get_mut(&client).filter(|held| held.wish.id == id && held.first <= tick) {
                held.newest = Some(bytes);
            }
        }
    }

    /// The newest message for a client, once.
    pub fn take(&self, client: u64) -> Option<Bytes> {
        self.held().get_mut(&client)?.newest.take()
    }

    /// The smallest interval at which anybody follows points, ticks.
    pub fn interval(&self) -> Option<i64> {
        self.held().values().map(|held| held.wish.interval).min()
    }

    /// Points of all clients.
    pub fn live(&self) -> usize {
        self.held().values().map(|held| held.wish.points.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(client: u64, id: u64, n: usize) -> PointsWish {
        PointsWish { client, id, interval: 240, points: vec![[0.0; 2]; n].into() }
    }

    fn message(client: u64, id: u64, tick: i64) -> PointsMessage {
        PointsMessage { client, id, tick, bytes: Bytes::from(tick.to_string()) }
    }

    #[test]
    fn the_newest_message_of_the_newest_wish_is_given_once() {
        let board = PointsBoard::new(10);
        let told = std::cell::Cell::new(0);
        let replace = |wish| board.replace(wish, |wishes| told.set(wishes.len()), || 1000);
        assert_eq!(replace(wish(1, 7, 4)), Ok(1200));
        board.post(vec![message(1, 7, 960), message(2, 7, 1200)]);
        assert_eq!(board.take(1), None, "a tick before the one that was promised");
        board.post(vec![message(1, 7, 1200)]);
        board.post(vec![message(1, 7, 1440)]);
        assert_eq!((board.take(1), board.take(1)), (Some(Bytes::from("1440")), None));
        assert_eq!(replace(wish(1, 8, 10)), Ok(1200), "its own points make room");
        board.post(vec![message(1, 7, 1680)]);
        assert_eq!(board.take(1), None, "of a wish that is no more");
        assert_eq!((replace(wish(2, 1, 1)), told.get()), (Err(0), 1));
        assert_eq!((replace(wish(1, 9, 0)), told.get(), board.live()), (Ok(1200), 0, 0));
        assert_eq!((replace(wish(2, 1, 1)), told.get()), (Ok(1200), 1));
        board.remove(2, |wishes| told.set(wishes.len()));
        board.remove(2, |_| panic!("it is gone already"));
        board.post(vec![message(2, 1, 1200)]);
        assert_eq!((board.take(2), told.get()), (None, 0), "nothing is kept for a client that is gone");
    }
}
