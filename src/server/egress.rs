//! How many bytes a second may leave, where an operator says so: who would be one too many is not let in, and where that
//! doesn't help, everybody gets less.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// What a client is taken to need before any is measured, bytes a second: 10 Mb/s.
const GUESS: f64 = 1.25e6;
/// Seconds above the budget before everybody gets less, and seconds in which that shows.
const OVER: u32 = 2;
const SETTLE: u32 = 3;
/// Seconds below this share of the budget before everybody gets more again: a rung up may double what leaves.
const UNDER: u32 = 20;
const LOW: f64 = 0.45;
/// Most rungs that are taken from everybody.
const MOST: usize = 4;

/// The budget, and what is used of it.
#[derive(Debug)]
pub struct Egress {
    /// Bytes a second; `None`: as many as there are.
    budget: Option<f64>,
    measured: Mutex<Measured>,
    squeeze: AtomicUsize,
}

#[derive(Debug, Default)]
struct Measured {
    /// Bytes sent in all, at a time of the server.
    sent: u64,
    at_us: i64,
    /// Bytes a second, and what one client takes of them.
    rate: f64,
    each: Option<f64>,
    /// Clients that were let in since, and in the second before that: not all they need is measured yet.
    admitted: [u32; 2],
    over: u32,
    under: u32,
    settling: u32,
}

impl Egress {
    /// A budget in megabits a second, if there is one.
    pub fn new(mbps: Option<f64>) -> Self {
        let budget = mbps.map(|mbps| mbps * 125e3);
        Self { budget, measured: Mutex::default(), squeeze: AtomicUsize::new(0) }
    }

    /// Whether one more client can be let in, who then counts.
    pub fn admit(&self) -> bool {
        let Some(budget) = self.budget else { return true };
        let mut measured = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let each = measured.each.unwrap_or(GUESS);
        let coming = f64::from(measured.admitted.iter().sum::<u32>());
        let fits = self.squeeze() == 0 && measured.rate + (coming + 1.0) * each <= budget;
        measured.admitted[0] += u32::from(fits);
        fits
    }

    /// Rungs that are taken from everybody.
    pub fn squeeze(&self) -> usize {
        self.squeeze.load(Relaxed)
    }

    /// Once a second: how many bytes have been sent in all, to how many clients that are here.
    pub fn beat(&self, now_us: i64, sent: u64, clients: usize) {
        let Some(budget) = self.budget else { return };
        let mut measured = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let seconds = (now_us - measured.at_us) as f64 / 1e6;
        if seconds < 0.2 {
            return;
        }
        let rate = (sent - measured.sent) as f64 / seconds;
        let [new, before] = measured.admitted;
        // Those that have just come don't take all they will.
        let whole = clients.saturating_sub((new + before) as usize);
        if whole > 0 && rate > 0.0 {
            measured.each = Some(rate / whole as f64);
        }
        (measured.sent, measured.at_us, measured.rate, measured.admitted) = (sent, now_us, rate, [0, new]);
        measured.over = if rate > budget { measured.over + 1 } else { 0 };
        measured.under = if rate < LOW * budget { measured.under + 1 } else { 0 };
        measured.settling = measured.settling.saturating_sub(1);
        if measured.settling > 0 {
            return;
        }
        let squeeze = self.squeeze();
        let next = match () {
            () if measured.over >= OVER => (squeeze + 1).min(MOST),
            () if measured.under >= UNDER => squeeze.saturating_sub(1),
            () => squeeze,
        };
        if next != squeeze {
            tracing::warn!(squeeze = next, mbps = rate / 125e3, "the budget of bytes that may leave");
            self.squeeze.store(next, Relaxed);
            (measured.over, measured.under, measured.settling) = (0, 0, SETTLE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEGABIT: u64 = 125_000;

    /// `seconds` in which so many clients take so much each.
    fn pass(egress: &Egress, second: &mut i64, sent: &mut u64, seconds: i64, clients: usize, mbps: u64) {
        for _ in 0..seconds {
            *second += 1;
            *sent += clients as u64 * mbps * MEGABIT;
            egress.beat(*second * 1_000_000, *sent, clients);
        }
    }

    #[test]
    fn as_many_are_let_in_as_fit() {
        let egress = Egress::new(Some(100.0));
        let (mut second, mut sent) = (0, 0);
        // Nothing is measured: ten at what is guessed.
        assert_eq!((0..20).filter(|_| egress.admit()).count(), 10);
        pass(&egress, &mut second, &mut sent, 3, 10, 5);
        // Each takes 5: ten more fit, however fast they come.
        assert_eq!((0..20).filter(|_| egress.admit()).count(), 10);
        pass(&egress, &mut second, &mut sent, 3, 20, 5);
        assert!(!egress.admit());
        pass(&egress, &mut second, &mut sent, 3, 19, 5);
        assert!(egress.admit());
        assert!((0..1000).all(|_| Egress::new(None).admit()));
    }

    #[test]
    fn when_those_who_are_there_need_more_all_get_less_and_nobody_comes() {
        let egress = Egress::new(Some(100.0));
        let (mut second, mut sent) = (0, 0);
        pass(&egress, &mut second, &mut sent, 5, 10, 9);
        assert_eq!(egress.squeeze(), 0);
        // A storm.
        pass(&egress, &mut second, &mut sent, 2, 10, 18);
        assert_eq!(egress.squeeze(), 1);
        pass(&egress, &mut second, &mut sent, 1, 10, 18);
        assert_eq!(egress.squeeze(), 1, "what was just done must show first");
        pass(&egress, &mut second, &mut sent, 30, 10, 9);
        assert_eq!((egress.squeeze(), egress.admit()), (1, false));
        pass(&egress, &mut second, &mut sent, 21, 10, 4);
        assert_eq!((egress.squeeze(), egress.admit()), (0, true));
    }
}
