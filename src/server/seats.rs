//! Counts connections, in all and per address, and refuses those above the caps.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::Notify;

/// All seats of a server.
#[derive(Debug)]
pub struct Seats {
    most: usize,
    most_per_address: usize,
    taken: Mutex<Taken>,
    left: Notify,
}

#[derive(Debug, Default)]
struct Taken {
    all: usize,
    by_address: HashMap<IpAddr, usize>,
}

/// One connection's seat, given back on drop.
#[derive(Debug)]
pub struct Seat {
    seats: Arc<Seats>,
    address: IpAddr,
}

impl Seats {
    /// Seats for `most` connections, of which one address may hold `most_per_address`.
    pub fn new(most: usize, most_per_address: usize) -> Arc<Self> {
        Arc::new(Self { most, most_per_address, taken: Mutex::default(), left: Notify::new() })
    }

    /// A seat, unless the house is full.
    pub fn take(self: &Arc<Self>, address: IpAddr) -> Option<Seat> {
        // One host is one host, whichever way it is written.
        let address = address.to_canonical();
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let here = taken.by_address.get(&address).copied().unwrap_or(0);
        if taken.all >= self.most || here >= self.most_per_address {
            return None;
        }
        taken.all += 1;
        taken.by_address.insert(address, here + 1);
        Some(Seat { seats: Arc::clone(self), address })
    }

    /// Connections now.
    pub fn taken(&self) -> usize {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).all
    }

    /// Returns when all seats are free.
    pub async fn empty(&self) {
        loop {
            let left = self.left.notified();
            if self.taken() == 0 {
                return;
            }
            left.await;
        }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        {
            let mut taken = self.seats.taken.lock().unwrap_or_else(PoisonError::into_inner);
            taken.all -= 1;
            if let Some(here) = taken.by_address.get_mut(&self.address) {
                *here -= 1;
                if *here == 0 {
                    taken.by_address.remove(&self.address);
                }
            }
        }
        self.seats.left.notify_waiters();
    }
}
