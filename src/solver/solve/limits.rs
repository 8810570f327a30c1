//! Record of the limits on the increments of a step: at most 64 time intervals, each with its smallest increment and
//! the reason for it.

use serde::Serialize;

use crate::plan::Plan;
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive, persist_fields};

/// Largest number of intervals; when it is reached, the number of increments per interval is doubled.
const SPANS: usize = 64;

/// Reason for the length of an increment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IncrementLimiter {
    /// Fixed by the deck.
    #[default]
    Given,
    /// Error control of the motion of rigid bodies.
    Accuracy,
    /// Stability of the elements.
    Elements,
    /// Stability of heat conduction.
    Conduction,
    /// A time function of heat that jumps or changes fast.
    Heat,
    /// Largest increment that the deck allows.
    Longest,
    /// A load or a constraint, by its row of the ledger.
    Effect(EffectId),
    /// The end of the step.
    Step,
    /// A body that comes to rest.
    Rest,
}

impl IncrementLimiter {
    /// Returns all limiters, in the order of their numbers in an archive.
    fn all(effect: EffectId) -> [IncrementLimiter; 9] {
        use IncrementLimiter::{Accuracy, Conduction, Effect, Elements, Given, Heat, Longest, Rest, Step};
        [Given, Accuracy, Elements, Conduction, Heat, Longest, Effect(effect), Step, Rest]
    }

    /// Returns two numbers for an archive: of the limiter and of its effect.
    fn code(self) -> [usize; 2] {
        let effect = if let IncrementLimiter::Effect(effect) = self { effect } else { 0 };
        let number = IncrementLimiter::all(effect).iter().position(|limiter| *limiter == self);
        [number.unwrap_or_default(), effect]
    }

    fn of_code([number, effect]: [usize; 2]) -> IncrementLimiter {
        IncrementLimiter::all(effect).get(number).copied().unwrap_or_default()
    }
}

impl Persist for IncrementLimiter {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut code = self.code();
        code.persist(archive);
        *self = IncrementLimiter::of_code(code);
    }
}

/// Interval of total time, with its smallest increment and the reason for that increment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
struct IncrementSpan {
    /// Total time at the start of the interval.
    time: f64,
    shortest: f64,
    by: IncrementLimiter,
    /// Group and element that limit the increment, if elements or conduction do.
    place: (usize, usize),
}

impl IncrementSpan {
    /// Takes the other interval if its smallest increment is shorter. The end of the step is replaced by any other
    /// reason, because it says nothing about the model.
    fn take(&mut self, other: &IncrementSpan) {
        let (ends, other_ends) = (self.by == IncrementLimiter::Step, other.by == IncrementLimiter::Step);
        if ends && !other_ends || ends == other_ends && other.shortest < self.shortest {
            *self = IncrementSpan { time: self.time, ..*other };
        }
    }
}

/// Smallest increments of a step, in intervals with equal numbers of increments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IncrementLimits {
    spans: Vec<IncrementSpan>,
    /// Increments per interval.
    stride: u64,
    /// Increments in the last interval so far.
    in_last: u64,
}

impl IncrementLimits {
    /// Starts a step; allocates all intervals.
    pub fn begin() -> IncrementLimits {
        IncrementLimits { spans: Vec::with_capacity(SPANS), stride: 1, in_last: 0 }
    }

    /// Adds an increment that starts at the total time `time`.
    #[inline]
    pub fn take(&mut self, time: f64, length: f64, by: IncrementLimiter, place: (usize, usize)) {
        let is_of_element = matches!(by, IncrementLimiter::Elements | IncrementLimiter::Conduction);
        let span = IncrementSpan { time, shortest: length, by, place: if is_of_element { place } else { (0, 0) } };
        match self.spans.last_mut() {
            Some(last) if self.in_last < self.stride => last.take(&span),
            _ => self.open(span),
        }
        self.in_last += 1;
    }

    fn open(&mut self, span: IncrementSpan) {
        if self.spans.len() == SPANS {
            for i in 0..SPANS / 2 {
                let mut pair = self.spans[2 * i];
                pair.take(&self.spans[2 * i + 1]);
                self.spans[i] = pair;
            }
            self.spans.truncate(SPANS / 2);
            self.stride *= 2;
        }
        self.spans.push(span);
        self.in_last = 0;
    }

    /// Returns the record with names from the plan; empty if there was no increment.
    pub fn named(&self, plan: &Plan) -> LimitsOverTime {
        let mut record = LimitsOverTime::default();
        let mut known: Vec<(IncrementLimiter, (usize, usize))> = Vec::new();
        for span in &self.spans {
            let limit = (span.by, span.place);
            let index = known.iter().position(|k| *k == limit).unwrap_or_else(|| {
                known.push(limit);
                record.names.push(name(span, plan));
                known.len() - 1
            });
            record.by.push(index);
            record.time.push(span.time);
            record.increment.push(span.shortest);
        }
        record
    }
}

fn name(span: &IncrementSpan, plan: &Plan) -> String {
    let element = || plan.element_name(span.place.0, span.place.1);
    match span.by {
        IncrementLimiter::Given => "fixed by the deck".into(),
        IncrementLimiter::Accuracy => "accuracy of the motion".into(),
        IncrementLimiter::Elements => format!("element {}", element()),
        IncrementLimiter::Conduction => format!("conduction in element {}", element()),
        IncrementLimiter::Heat => "time function of heat".into(),
        IncrementLimiter::Longest => "largest increment of the deck".into(),
        IncrementLimiter::Effect(id) => plan.ledger.effects.get(id).map_or(String::new(), |row| row.effect.clone()),
        IncrementLimiter::Step => "end of the step".into(),
        IncrementLimiter::Rest => "a body comes to rest".into(),
    }
}

/// Limits on the increments of a step over time: the smallest increment in each of at most 64 intervals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Persist)]
pub struct LimitsOverTime {
    /// Total time at the start of each interval.
    pub time: Vec<f64>,
    /// Smallest increment in each interval.
    pub increment: Vec<f64>,
    /// Reason for each of these increments, as an index of `names`.
    pub by: Vec<usize>,
    /// Names of the reasons.
    pub names: Vec<String>,
}

impl Persist for IncrementLimits {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let IncrementLimits { spans, stride, in_last } = self;
        persist_fields!(archive; spans, stride, in_last);
        self.spans.reserve_exact(SPANS.saturating_sub(self.spans.len()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_step_keeps_the_shortest_increment_of_each_span() {
        let mut limits = IncrementLimits::begin();
        let capacity = limits.spans.capacity();
        for i in 0..10_000_u32 {
            let (length, limiter) =
                if i == 7777 { (0.5, IncrementLimiter::Rest) } else { (1.0, IncrementLimiter::Elements) };
            limits.take(f64::from(i), length, limiter, (0, 0));
        }
        limits.take(10_000.0, 1e-9, IncrementLimiter::Step, (0, 0));
        assert_eq!(limits.spans.capacity(), capacity, "no memory was allocated");
        assert!((SPANS / 2..=SPANS).contains(&limits.spans.len()));
        let short: Vec<&IncrementSpan> = limits.spans.iter().filter(|s| s.shortest < 1.0).collect();
        assert_eq!(short.len(), 1, "the end of the step replaces no other limit");
        assert!(short[0].by == IncrementLimiter::Rest && (short[0].time - 7777.0).abs() < 256.0);
        assert!(limits.spans.is_sorted_by(|a, b| a.time < b.time));
    }

    #[test]
    fn codes_convert_back_to_limiters() {
        IncrementLimiter::all(7).into_iter().for_each(|l| assert_eq!(IncrementLimiter::of_code(l.code()), l));
    }
}
