//! What limited the increments of a step: a few dozen spans of time, each with its shortest increment and what limited that.
//! Never here: the choice of an increment (`increment`).

use serde::Serialize;

use crate::plan::Plan;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};

/// Most spans that are kept: twice as many increments then go into each.
const SPANS: usize = 64;

/// What an increment is no longer for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Limiter {
    /// The deck gives the increment.
    #[default]
    Given,
    /// The error estimate of the motion of bodies.
    Accuracy,
    /// The stability of elements.
    Elements,
    /// The stability of conduction.
    Conduction,
    /// A magnitude of heat that jumps, or changes fast.
    Heat,
    /// The longest increment that the deck allows.
    Longest,
    /// A load or a constraint, by its row of the ledger.
    Effect(EffectId),
    /// The end of the step.
    Step,
    /// A body that comes to rest.
    Rest,
}

impl Limiter {
    /// Two numbers for an archive.
    fn code(self) -> [usize; 2] {
        match self {
            Limiter::Given => [0, 0],
            Limiter::Accuracy => [1, 0],
            Limiter::Elements => [2, 0],
            Limiter::Conduction => [3, 0],
            Limiter::Heat => [4, 0],
            Limiter::Longest => [5, 0],
            Limiter::Effect(id) => [6, id],
            Limiter::Step => [7, 0],
            Limiter::Rest => [8, 0],
        }
    }

    fn of_code([kind, id]: [usize; 2]) -> Limiter {
        use Limiter::{Accuracy, Conduction, Effect, Elements, Given, Heat, Longest, Rest, Step};
        let all = [Given, Accuracy, Elements, Conduction, Heat, Longest, Effect(id), Step, Rest];
        all.get(kind).copied().unwrap_or_default()
    }
}

impl Persist for Limiter {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut code = self.code();
        code.persist(archive);
        *self = Limiter::of_code(code);
    }
}

/// A span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Span {
    /// Total time at its beginning.
    time: f64,
    shortest: f64,
    by: Limiter,
    /// Group and element, where elements or conduction limit.
    place: (usize, usize),
}

impl Span {
    /// The end of a step says nothing of the scene, so anything else counts more.
    fn take(&mut self, other: &Span) {
        let (ends, other_ends) = (self.by == Limiter::Step, other.by == Limiter::Step);
        if ends && !other_ends || ends == other_ends && other.shortest < self.shortest {
            *self = Span { time: self.time, ..*other };
        }
    }
}

/// What is kept while a step runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    spans: Vec<Span>,
    /// Increments in a span, and in the last one so far.
    stride: u64,
    in_last: u64,
}

impl Limits {
    /// At the beginning of a step: all the room that will be needed.
    pub fn begin() -> Limits {
        Limits { spans: Vec::with_capacity(SPANS), stride: 1, in_last: 0 }
    }

    /// An increment from a total time on.
    #[inline]
    pub fn take(&mut self, time: f64, length: f64, by: Limiter, place: (usize, usize)) {
        let place = if matches!(by, Limiter::Elements | Limiter::Conduction) { place } else { (0, 0) };
        let span = Span { time, shortest: length, by, place };
        match self.spans.last_mut() {
            Some(last) if self.in_last < self.stride => last.take(&span),
            _ => self.open(span),
        }
        self.in_last += 1;
    }

    fn open(&mut self, span: Span) {
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

    /// With the names of a plan; empty where no increment was taken.
    pub fn named(&self, plan: &Plan) -> LimitsOverTime {
        let mut told = LimitsOverTime::default();
        let mut known: Vec<(Limiter, (usize, usize))> = Vec::new();
        for span in &self.spans {
            let limit = (span.by, span.place);
            let by = known.iter().position(|k| *k == limit).unwrap_or_else(|| {
                known.push(limit);
                told.names.push(name(span, plan));
                known.len() - 1
            });
            told.by.push(by);
            told.time.push(span.time);
            told.increment.push(span.shortest);
        }
        told
    }
}

fn name(span: &Span, plan: &Plan) -> String {
    let element = || plan.element_name(span.place.0, span.place.1);
    match span.by {
        Limiter::Given => "the deck gives it".into(),
        Limiter::Accuracy => "accuracy of the motion".into(),
        Limiter::Elements => format!("element {}", element()),
        Limiter::Conduction => format!("conduction in element {}", element()),
        Limiter::Heat => "heat over time".into(),
        Limiter::Longest => "longest that the deck allows".into(),
        Limiter::Effect(id) => plan.ledger.effects.get(id).map_or(String::new(), |row| row.effect.clone()),
        Limiter::Step => "end of the step".into(),
        Limiter::Rest => "a body comes to rest".into(),
    }
}

/// What limited the increments of a step over time: in each of at most 64 spans the shortest one.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LimitsOverTime {
    /// Total time at which each span begins.
    pub time: Vec<f64>,
    /// Its shortest increment.
    pub increment: Vec<f64>,
    /// What limited that, as an index of `names`.
    pub by: Vec<usize>,
    /// What limited any.
    pub names: Vec<String>,
}

persist_struct!(Span { time, shortest, by, place });

impl Persist for Limits {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Limits { spans, stride, in_last } = self;
        persist_fields!(archive; spans, stride, in_last);
        self.spans.reserve_exact(SPANS.saturating_sub(self.spans.len()));
    }
}

persist_struct!(LimitsOverTime { time, increment, by, names });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_step_keeps_the_shortest_increment_of_each_span() {
        let mut limits = Limits::begin();
        let room = limits.spans.capacity();
        for i in 0..10_000_u32 {
            let (length, by) = if i == 7777 { (0.5, Limiter::Rest) } else { (1.0, Limiter::Elements) };
            limits.take(f64::from(i), length, by, (0, 0));
        }
        limits.take(10_000.0, 1e-9, Limiter::Step, (0, 0));
        assert_eq!(limits.spans.capacity(), room, "nothing was allocated");
        assert!((SPANS / 2..=SPANS).contains(&limits.spans.len()));
        let short: Vec<&Span> = limits.spans.iter().filter(|s| s.shortest < 1.0).collect();
        assert_eq!(short.len(), 1, "the end of the step hides nothing");
        assert!(short[0].by == Limiter::Rest && (short[0].time - 7777.0).abs() < 256.0);
        assert!(limits.spans.is_sorted_by(|a, b| a.time < b.time));
    }

    #[test]
    fn codes_lead_back() {
        let all = [Limiter::Given, Limiter::Accuracy, Limiter::Elements, Limiter::Conduction, Limiter::Heat];
        let more = [Limiter::Longest, Limiter::Effect(7), Limiter::Step, Limiter::Rest];
        all.into_iter().chain(more).for_each(|l| assert_eq!(Limiter::of_code(l.code()), l));
    }
}
