//! A stream client's place: what it subscribes to, the points that it follows, and room for both.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bytes::Bytes;

use super::hello;
use super::ocean::Ocean;
use crate::engine::PointsWish;
use crate::wire::UnitName;

/// A client's place; leaving it ends its subscription.
pub struct Client {
    ocean: Arc<Ocean>,
    id: u64,
}

impl Ocean {
    /// A place for one more client, unless the house is full.
    pub fn join(self: &Arc<Self>) -> Option<Client> {
        let more = |clients: usize| (clients < self.settings.clients).then_some(clients + 1);
        self.clients.fetch_update(Relaxed, Relaxed, more).ok()?;
        Some(Client { ocean: Arc::clone(self), id: self.next_client.fetch_add(1, Relaxed) })
    }
}

impl Client {
    /// Replaces this client's subscription, units with their intervals, and tells the engine. Returns what the client
    /// gets, in the order asked.
    ///
    /// # Errors
    /// Index of the unit that can't be had.
    pub fn subscribe(&self, units: &[(UnitName, i64)]) -> Result<Vec<(UnitName, i64)>, usize> {
        let units = self.ocean.source.grant(units)?;
        self.ocean.wish(|subscriptions| subscriptions.replace(self.id, &units))
    }

    /// Asks for frames of these units that can be read with nothing before them.
    pub fn join_units(&self, units: Vec<UnitName>) {
        if !units.is_empty() {
            self.ocean.source.join(units);
        }
    }

    /// Replaces the points that this client follows, and tells the engine. Returns the first tick that will come.
    ///
    /// # Errors
    /// How many points it may follow.
    pub fn follow(&self, id: u64, interval: i64, points: Vec<[f64; 2]>) -> Result<i64, usize> {
        let wish = PointsWish { client: self.id, id, interval, points: points.into() };
        let tell = |wishes| self.ocean.source.set_points(wishes);
        self.ocean.points.replace(wish, tell, || self.ocean.tick() + hello::reach())
    }

    /// The newest water at its points, once.
    pub fn water(&self) -> Option<Bytes> {
        self.ocean.points.take(self.id)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.ocean.points.remove(self.id, |wishes| self.ocean.source.set_points(wishes));
        self.ocean.wish(|subscriptions| subscriptions.remove(self.id));
        self.ocean.clients.fetch_sub(1, Relaxed);
    }
}
