//! What the boundaries of several steps come to: which one holds a node, how large it is, and what goes on into the next step
//! (ABAQUS Analysis User's Guide 34.1.2, "Continuation of an amplitude reference in subsequent steps", and 34.3.1).
//! Never here: cards, loads.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::types::{Amplitude, AmplitudeDefinition, AmplitudeId, Boundary, Load, Model, Motion, PrescribedField};
use crate::deck::{Diagnostic, Span};
use crate::kernel::amplitude::Curve;

/// Displacements closer than this fraction of a prescribed one are no jump.
const JUMP: f64 = 1e-9;
/// Name of amplitudes that `*STEP, AMPLITUDE=RAMP` makes.
const RAMP: &str = "RAMP";

/// A degree of freedom of a node.
type Dof = (usize, u8);

/// What earlier steps leave to later ones.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    /// Boundaries in force, as large as they stay.
    pub boundaries: Vec<Boundary>,
    /// Loads in force, likewise.
    pub loads: Vec<Load>,
    /// Field variables in force, likewise.
    pub fields: Vec<PrescribedField>,
    /// Total time at which the next step begins.
    time: f64,
    /// Displacements that are known beforehand; before the first step all are zero.
    places: HashMap<Dof, f64>,
    /// What the amplitudes of displacements in force began with, by their data lines.
    first_values: HashMap<(Span, AmplitudeId), f64>,
    /// Whether a step is over.
    begun: bool,
}

/// The step that conditions are of.
pub(super) struct StepTime {
    /// Length, time.
    pub duration: f64,
    /// Whether conditions without amplitude grow over the step (`*STEP, AMPLITUDE=RAMP`).
    pub ramp: bool,
}

impl History {
    /// Boundaries in force in a step that gives these; what follows from them is remembered for the next.
    pub fn boundaries(
        &mut self,
        given: Vec<Boundary>,
        step: &StepTime,
        model: &mut Model,
        words: &mut Vec<Diagnostic>,
    ) -> Vec<Boundary> {
        let given = if step.ramp { self.ramped_boundaries(given, step, model) } else { given };
        let spans: HashSet<Span> = given.iter().map(|b| b.span).collect();
        let merged = merge_boundaries(std::mem::take(&mut self.boundaries), given, words);
        self.boundaries = merged.iter().map(|b| self.settled_boundary(b, step, model)).collect();
        let places = self.places_after(&merged, step, model);
        self.first_values.retain(|(span, _), _| !spans.contains(span));
        let mut in_force = Vec::with_capacity(merged.len());
        for b in merged {
            words.extend(self.unknown_start(&b, model));
            if spans.contains(&b.span) {
                words.extend(self.jump(&b, model));
            }
            in_force.push(self.since_start(b, model));
        }
        self.places = places;
        in_force
    }

    /// Boundaries given before the first step hold from then on.
    pub fn model_data(&mut self, given: Vec<Boundary>, words: &mut Vec<Diagnostic>) {
        self.boundaries = merge_boundaries(Vec::new(), given, words);
    }

    /// The step is over.
    pub fn end(&mut self, step: &StepTime) {
        self.time += step.duration;
        self.begun = true;
    }

    /// Value of an amplitude at a time of the step; `None` for one that a routine gives.
    pub(super) fn amplitude(&self, amplitude: Option<AmplitudeId>, step_time: f64, model: &Model) -> Option<f64> {
        let Some(id) = amplitude else { return Some(1.0) };
        let curve = curve(&model.amplitudes[id])?;
        Some(curve.value(if curve.total_time { self.time + step_time } else { step_time }))
    }

    /// What stays of an amplitude after its step: one in total time goes on, and so does a routine, which knows the step. One
    /// in step time is constant from then on.
    pub(super) fn stays(&self, amplitude: Option<AmplitudeId>, step: &StepTime, model: &Model) -> Option<f64> {
        let in_total_time = |a: &Amplitude| matches!(a.definition, AmplitudeDefinition::Curve { total_time: true, .. });
        let id = amplitude.filter(|&id| !in_total_time(&model.amplitudes[id]))?;
        self.amplitude(Some(id), step.duration, model)
    }

    fn settled_boundary(&self, boundary: &Boundary, step: &StepTime, model: &mut Model) -> Boundary {
        let mut settled = boundary.clone();
        if let Some(factor) = self.stays(boundary.amplitude, step, model) {
            if boundary.user {
                settled.amplitude = Some(constant(factor, boundary.amplitude, model));
            } else {
                (settled.value, settled.amplitude) = (boundary.value * factor, None);
            }
        }
        settled
    }

    /// Displacements at the end of a step, where they are known beforehand.
    fn places_after(&self, boundaries: &[Boundary], step: &StepTime, model: &Model) -> HashMap<Dof, f64> {
        let mut places = HashMap::new();
        for b in boundaries.iter().filter(|b| !b.user) {
            let ends = [0.0, step.duration].map(|t| self.amplitude(b.amplitude, t, model));
            let moved = match (b.kind, b.value, ends) {
                (Motion::Displacement, value, [Some(first), Some(last)]) => value * (last - first),
                (Motion::Velocity, 0.0, _) => 0.0,
                _ => continue,
            };
            for &node in &b.nodes {
                if let Some(place) = self.place((node, b.dof)) {
                    places.insert((node, b.dof), place + moved);
                }
            }
        }
        places
    }

    /// Displacement when the step begins, where it is known beforehand.
    fn place(&self, dof: Dof) -> Option<f64> {
        if self.begun { self.places.get(&dof).copied() } else { Some(0.0) }
    }

    /// A displacement that a routine gives by its amplitude begins a later step with a value that nothing knows beforehand.
    fn unknown_start(&self, b: &Boundary, model: &Model) -> Option<Diagnostic> {
        let routine = self.amplitude(b.amplitude, 0.0, model).is_none();
        if !(self.begun && routine && b.kind == Motion::Displacement && !b.user) {
            return None;
        }
        let message = "a displacement that follows a user amplitude beyond the first step is not supported";
        let finding = Diagnostic::error("M104", message).at(b.span, "in force in a later step");
        Some(finding.help("prescribe a velocity, or give *BOUNDARY, USER"))
    }

    /// What to say of a displacement that does not begin where its nodes are.
    fn jump(&self, b: &Boundary, model: &Model) -> Option<Diagnostic> {
        let first = self.amplitude(b.amplitude, 0.0, model)? * b.value;
        if b.kind != Motion::Displacement || b.user || b.amplitude.is_none() || b.value == 0.0 {
            return None;
        }
        let places: Vec<Option<f64>> = b.nodes.iter().map(|&n| self.place((n, b.dof))).collect();
        if places.contains(&None) {
            let message = format!(
                "where the nodes of `{}` are when the step begins is not known beforehand: their displacement goes on from there",
                b.set
            );
            return Some(Diagnostic::note("M147", message).at(b.span, "a displacement after a free or other motion"));
        }
        let jumps = |place: &f64| (first - place).abs() > JUMP * (first.abs() + b.value.abs());
        let place = places.into_iter().flatten().find(jumps)?;
        let message = format!(
            "the displacement of `{}` would jump from {place} to {first} as the step begins: the jump is ignored, and the motion \
             goes on from where the nodes are",
            b.set
        );
        let finding = Diagnostic::warning("M146", message).at(b.span, "as ABAQUS/Explicit does");
        Some(finding.help("let the amplitude begin with the displacement that the nodes have"))
    }

    /// A displacement counts from where its nodes are when it begins: what its amplitude begins with is taken off, in the steps
    /// in which it goes on as well.
    fn since_start(&mut self, mut b: Boundary, model: &mut Model) -> Boundary {
        if b.kind != Motion::Displacement || b.user {
            return b;
        }
        let Some(index) = b.amplitude else { return b };
        let first =
            self.first_values.get(&(b.span, index)).copied().or_else(|| self.amplitude(b.amplitude, 0.0, model));
        self.first_values.extend(first.map(|first| ((b.span, index), first)));
        if let Some(first) = first.filter(|f| *f != 0.0) {
            let mut shifted = model.amplitudes[index].clone();
            if let AmplitudeDefinition::Curve { points, .. } = &mut shifted.definition {
                points.iter_mut().for_each(|p| p[1] -= first);
            }
            b.amplitude = Some(place_of(shifted, model));
        }
        b
    }

    /// Boundaries without amplitude that grow linearly over the step, from what they were at its beginning.
    fn ramped_boundaries(&self, given: Vec<Boundary>, step: &StepTime, model: &mut Model) -> Vec<Boundary> {
        let mut before: HashMap<(Dof, Motion), f64> = HashMap::new();
        for b in &self.boundaries {
            let value = self.amplitude(b.amplitude, 0.0, model).unwrap_or(0.0) * b.value;
            before.extend(b.nodes.iter().map(|&n| (((n, b.dof), b.kind), value)));
        }
        let from = |node: usize, b: &Boundary| match b.kind {
            Motion::Displacement => self.place((node, b.dof)).unwrap_or(0.0),
            kind => before.get(&((node, b.dof), kind)).copied().unwrap_or(0.0),
        };
        let mut ramped = Vec::new();
        for b in given {
            if b.user || b.amplitude.is_some() {
                ramped.push(b);
                continue;
            }
            let mut groups: IndexMap<u64, Vec<usize>> = IndexMap::new();
            for &node in &b.nodes {
                groups.entry(from(node, &b).to_bits()).or_default().push(node);
            }
            for (bits, nodes) in groups {
                let (value, amplitude) = ramp(f64::from_bits(bits), b.value, b.span, step, model);
                ramped.push(Boundary { nodes, value, amplitude, ..b.clone() });
            }
        }
        ramped
    }
}

fn curve(amplitude: &Amplitude) -> Option<Curve> {
    match &amplitude.definition {
        AmplitudeDefinition::Curve { points, smooth, total_time } => {
            Some(Curve::new(points.clone(), *smooth, *total_time))
        }
        AmplitudeDefinition::User { .. } => None,
    }
}

/// The index of an amplitude; one that there is already serves again, so that what goes on unchanged is equal from step to step.
fn place_of(amplitude: Amplitude, model: &mut Model) -> AmplitudeId {
    let known = model.amplitudes.iter().position(|a| *a == amplitude);
    AmplitudeId::new(known.unwrap_or_else(|| {
        model.amplitudes.push(amplitude);
        model.amplitudes.len() - 1
    }))
}

/// An amplitude that stays at what another came to.
pub(super) fn constant(factor: f64, other: Option<AmplitudeId>, model: &mut Model) -> AmplitudeId {
    let (name, span) = other.map_or_else(Default::default, |i| {
        let other = &model.amplitudes[i];
        (other.name.clone(), other.span)
    });
    let definition = AmplitudeDefinition::Curve { points: vec![[0.0, factor]], smooth: false, total_time: false };
    place_of(Amplitude { name, definition, absolute: false, span }, model)
}

/// Value and amplitude of what grows linearly over a step from one value to another.
pub(super) fn ramp(from: f64, to: f64, span: Span, step: &StepTime, model: &mut Model) -> (f64, Option<AmplitudeId>) {
    if from == to {
        return (to, None);
    }
    let value = if to == 0.0 { from } else { to };
    let points = vec![[0.0, from / value], [step.duration, to / value]];
    let definition = AmplitudeDefinition::Curve { points, smooth: false, total_time: false };
    (value, Some(place_of(Amplitude { name: RAMP.into(), definition, absolute: false, span }, model)))
}

/// Whether two boundaries say the same of a degree of freedom.
fn same_condition(a: &Boundary, b: &Boundary) -> bool {
    let holds = |b: &Boundary| {
        let ignored = b.kind == Motion::Displacement && b.amplitude.is_none();
        !b.user && !matches!(b.kind, Motion::Acceleration | Motion::Temperature) && (b.value == 0.0 || ignored)
    };
    holds(a) && holds(b)
        || (a.kind, a.user, a.value.to_bits(), a.amplitude) == (b.kind, b.user, b.value.to_bits(), b.amplitude)
}

/// Earlier boundaries and then those of a step: a later one acts on the nodes that it names, where it says something else.
/// Two that differ in one step are told.
fn merge_boundaries(inherited: Vec<Boundary>, given: Vec<Boundary>, words: &mut Vec<Diagnostic>) -> Vec<Boundary> {
    let own = inherited.len();
    let all: Vec<Boundary> = inherited.into_iter().chain(given).collect();
    // Which boundary says last what a degree of freedom does.
    let mut last: HashMap<Dof, usize> = HashMap::new();
    for (i, b) in all.iter().enumerate() {
        let mut told = false;
        for &node in &b.nodes {
            let holder = last.entry((node, b.dof)).or_insert(i);
            let earlier = &all[*holder];
            if *holder == i || same_condition(earlier, b) && (*holder >= own || i < own || earlier.nodes != b.nodes) {
                continue;
            }
            if *holder >= own && !told && !same_condition(earlier, b) {
                words.push(given_twice(earlier, b));
                told = true;
            }
            *holder = i;
        }
    }
    let trimmed = all.into_iter().enumerate().map(|(i, mut b)| {
        b.nodes.retain(|&n| last.get(&(n, b.dof)).is_none_or(|&holder| holder <= i));
        b
    });
    trimmed.filter(|b| !b.nodes.is_empty()).collect()
}

fn given_twice(earlier: &Boundary, later: &Boundary) -> Diagnostic {
    let message = format!(
        "`{}` and `{}` share nodes whose degree of freedom {} is given twice in this step, and differently: the later acts",
        earlier.set, later.set, later.dof
    );
    Diagnostic::warning("M145", message).at(later.span, "the later").at(earlier.span, "the earlier")
}
