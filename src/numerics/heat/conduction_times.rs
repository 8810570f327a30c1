//! Times at which heat rates of conduction are evaluated. Between them the rates are held: the stable time increment of
//! conduction is usually much longer than that of the motion.

use super::conductors::LargestRate;
use crate::state::archive::Persist;

/// Time of the last evaluation, and what the next one depends on.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: share)]
pub(super) struct ConductionTimes {
    /// Largest time over which rates are held, as a part of the stable time increment of conduction; 0 evaluates them in
    /// each increment.
    pub(super) share: f64,
    /// Highest rate of conduction, and its element.
    pub(super) rate: LargestRate,
    /// Whether the rates must be evaluated at the next instant.
    pub(super) is_due: bool,
    /// Total time of the last evaluation.
    evaluated_at: f64,
    /// Number of deleted elements at the last evaluation.
    deleted: usize,
}

impl Default for ConductionTimes {
    fn default() -> Self {
        ConductionTimes { share: 0.0, rate: (0.0, 0), is_due: true, evaluated_at: 0.0, deleted: 0 }
    }
}

impl ConductionTimes {
    /// Returns whether the rates are evaluated at this total time; they are then held from it on. Otherwise the rates remain
    /// in force over the next increment, which is assumed to be at most twice as long as the last one, `previous_dt`.
    pub(super) fn begin(&mut self, total_time: f64, previous_dt: f64, deleted: usize) -> bool {
        let held = total_time - self.evaluated_at + 2.0 * previous_dt;
        let is_held = !self.is_due && deleted == self.deleted && held * self.rate.0 <= 2.0 * self.share;
        if !is_held {
            (self.is_due, self.evaluated_at, self.deleted) = (false, total_time, deleted);
        }
        !is_held
    }
}

#[cfg(test)]
mod tests {
    use super::ConductionTimes;

    #[test]
    fn rates_are_held_for_a_part_of_the_stable_increment_unless_they_are_due() {
        let mut times = ConductionTimes { share: 0.1, rate: (2.0, 0), ..ConductionTimes::default() };
        // The stable increment is 1, so that rates are held for 0.1.
        let is_evaluated: Vec<bool> = (0..8).map(|i| times.begin(0.02 * f64::from(i), 0.02, 0)).collect();
        assert_eq!(is_evaluated, [true, false, false, false, true, false, false, false]);
        assert!(times.begin(0.15, 0.02, 1), "elements have been deleted");
        assert!(times.begin(0.16, 0.2, 1), "the increments are too long");
        times.is_due = true;
        assert!(times.begin(0.16, 0.02, 1));
        times.share = 0.0;
        assert!(times.begin(0.17, 0.01, 1));
    }
}
