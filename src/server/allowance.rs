//! How much of something may come at once, and how fast that allowance grows back.

/// An allowance that is used up until a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allowance {
    burst: i64,
    ticks_each: i64,
    used_until: i64,
}

impl Allowance {
    /// `burst` at once, and one every `ticks_each` ticks for long.
    pub const fn new(burst: i64, ticks_each: i64) -> Self {
        Self { burst, ticks_each, used_until: i64::MIN }
    }

    /// Uses up one at a tick, if there is one.
    pub fn take(&mut self, now: i64) -> bool {
        let used = self.used_until.max(now.saturating_sub(self.burst * self.ticks_each)) + self.ticks_each;
        if used > now {
            return false;
        }
        self.used_until = used;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Allowance;

    #[test]
    fn a_burst_passes_and_then_what_grows_back() {
        let mut allowance = Allowance::new(4, 100);
        assert_eq!((0..9).filter(|_| allowance.take(0)).count(), 4);
        assert_eq!((0..=1000).filter(|now| allowance.take(*now)).count(), 10);
        assert_eq!((0..9).filter(|_| allowance.take(100_000)).count(), 4, "no more than a burst is saved up");
    }
}
