//! How many bytes a second may leave, where an operator says so: who would be one too many is not let in, and where that
//! doesn't help, everybody gets less.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

/// What a client is taken to need before any is measured, bytes a second: 10 Mb/s.
const GUESS: f64 = 1.25e6;
/// Seconds above the budget before everybody gets less, and seconds in which that shows.
const OVER: u32 = 2;
const SETTLE: u32 = 3;
/// Seconds in which what would leave without the last rung is below this share of the budget, before it is given back.
const UNDER: u32 = 10;
const LOW: f64 = 0.9;
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
    /// Beats so far, and clients that are here of those let in since the last one, and since the one before: not all
    /// they need is measured yet.
    beats: u64,
    admitted: [u32; 2],
    over: u32,
    under: u32,
    settling: u32,
    /// What left before the newest rung was taken, and the shares that were left behind each.
    before: f64,
    left: Vec<f64>,
}

/// A client that was let in; it counts until it goes, or until what it takes is measured.
#[derive(Debug)]
pub struct Admitted {
    egress: Arc<Egress>,
    beat: u64,
}

impl Drop for Admitted {
    fn drop(&mut self) {
        let mut measured = self.egress.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let ago = measured.beats - self.beat;
        if let Some(admitted) = measured.admitted.get_mut(ago as usize) {
            *admitted = admitted.saturating_sub(1);
        }
    }
}

impl Egress {
    /// A budget in megabits a second, if there is one.
    pub fn new(mbps: Option<f64>) -> Self {
        let budget = mbps.map(|mbps| mbps * 125e3);
        Self { budget, measured: Mutex::default(), squeeze: AtomicUsize::new(0) }
    }

    /// Lets one more client in, if it fits.
    pub fn admit(self: &Arc<Self>) -> Option<Admitted> {
        let budget = self.budget.unwrap_or(f64::INFINITY);
        let mut measured = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let each = measured.each.unwrap_or(GUESS);
        let coming = f64::from(measured.admitted.iter().sum::<u32>());
        let fits = self.squeeze() == 0 && measured.rate + (coming + 1.0) * each <= budget;
        measured.admitted[0] += u32::from(fits);
        fits.then(|| Admitted { egress: Arc::clone(self), beat: measured.beats })
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
        measured.beats += 1;
        measured.over = if rate > budget { measured.over + 1 } else { 0 };
        let squeeze = self.squeeze();
        if measured.settling > 0 {
            measured.settling -= 1;
            if measured.settling == 0 && measured.left.len() < squeeze {
                // At most what two rungs leave: a crowd that has gone meanwhile says nothing of the rung.
                let left = (rate / measured.before).clamp(0.25, 1.0);
                measured.left.push(left);
            }
            return;
        }
        let whole = measured.left.last().map_or(rate, |left| rate / left);
        measured.under = if whole < LOW * budget { measured.under + 1 } else { 0 };
        let next = match () {
            () if measured.over >= OVER => (squeeze + 1).min(MOST),
            () if measured.under >= UNDER => squeeze.saturating_sub(1),
            () => squeeze,
        };
        if next != squeeze {
            tracing::warn!(squeeze = next, mbps = rate / 125e3, "the budget of bytes that may leave");
            self.squeeze.store(next, Relaxed);
            measured.before = rate;
            measured.left.truncate(next);
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
        let egress = Arc::new(Egress::new(Some(100.0)));
        let (mut second, mut sent) = (0, 0);
        let come = || (0..20).filter_map(|_| egress.admit()).collect::<Vec<_>>();
        // Nothing is measured: ten at what is guessed. Who goes again makes room.
        assert_eq!(come().len(), 10);
        let ten = come();
        assert_eq!((ten.len(), come().len()), (10, 0));
        pass(&egress, &mut second, &mut sent, 3, 10, 5);
        // Each takes 5: ten more fit, however fast they come.
        let more = come();
        assert_eq!(more.len(), 10);
        pass(&egress, &mut second, &mut sent, 3, 20, 5);
        drop((ten, more));
        assert_eq!(come().len(), 0, "what they took is still measured");
        pass(&egress, &mut second, &mut sent, 3, 19, 5);
        assert_eq!(come().len(), 1);
        let boundless = Arc::new(Egress::new(None));
        assert!((0..1000).all(|_| boundless.admit().is_some()));
    }

    #[test]
    fn when_those_who_are_there_need_more_all_get_less_and_nobody_comes() {
        let egress = Arc::new(Egress::new(Some(100.0)));
        let (mut second, mut sent) = (0, 0);
        pass(&egress, &mut second, &mut sent, 5, 10, 9);
        assert_eq!(egress.squeeze(), 0);
        // A storm.
        pass(&egress, &mut second, &mut sent, 2, 10, 18);
        assert_eq!(egress.squeeze(), 1);
        pass(&egress, &mut second, &mut sent, 1, 10, 18);
        assert_eq!(egress.squeeze(), 1, "what was just done must show first");
        pass(&egress, &mut second, &mut sent, 30, 10, 9);
        assert_eq!((egress.squeeze(), egress.admit().is_some()), (1, false));
        // It calms down: all of it would fit again.
        pass(&egress, &mut second, &mut sent, 11, 10, 4);
        assert_eq!((egress.squeeze(), egress.admit().is_some()), (0, true));
    }
}
