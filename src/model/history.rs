//! What the conditions of several steps come to: which boundary holds a node, which load acts at a place, how large they are
//! and what goes on into the next step (ABAQUS Analysis User's Guide 34.1.2, "Continuation of an amplitude reference in
//! subsequent steps", 34.3.1 and 34.4.1). Never here: cards.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::names::upper;
use super::types::{Amplitude, AmplitudeDefinition, Boundary, Load, LoadKind, Model, Motion, Side, Sides};
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
    /// Total time at which the next step begins.
    time: f64,
    /// Displacements that are known beforehand; before the first step all are zero.
    places: HashMap<Dof, f64>,
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
        let counted_from_place = |b: Boundary| {
            if spans.contains(&b.span) {
                words.extend(self.jump(&b, model));
            }
            self.counted_from_place(b, model)
        };
        let in_force = merged.into_iter().map(counted_from_place).collect();
        self.places = places;
        in_force
    }

    /// Boundaries given before the first step hold from then on.
    pub fn model_data(&mut self, given: Vec<Boundary>, words: &mut Vec<Diagnostic>) {
        self.boundaries = merge_boundaries(Vec::new(), given, words);
    }

    /// Loads in force in a step that gives these; what follows from them is remembered for the next.
    pub fn loads(
        &mut self,
        given: Vec<Load>,
        step: &StepTime,
        model: &mut Model,
        words: &mut Vec<Diagnostic>,
    ) -> Vec<Load> {
        let mut inherited = std::mem::take(&mut self.loads);
        let before = if step.ramp { self.magnitudes(&inherited, model) } else { HashMap::new() };
        replace_loads(&mut inherited, &given);
        words.extend(added_loads(&given));
        let given: Vec<Load> = match step.ramp {
            true => given.into_iter().flat_map(|l| ramped_load(l, &before, step, model)).collect(),
            false => given,
        };
        inherited.extend(given);
        self.loads = inherited.iter().map(|l| self.settled_load(l, step, model)).collect();
        inherited
    }

    /// The step is over.
    pub fn end(&mut self, step: &StepTime) {
        self.time += step.duration;
        self.begun = true;
    }

    /// Value of an amplitude at a time of the step; `None` for one that a routine gives.
    fn amplitude(&self, index: Option<usize>, step_time: f64, model: &Model) -> Option<f64> {
        let Some(index) = index else { return Some(1.0) };
        let curve = curve(&model.amplitudes[index])?;
        Some(curve.value(if curve.total_time { self.time + step_time } else { step_time }))
    }

    /// What stays of an amplitude after its step: one in total time goes on, and so does a routine, which knows the step. One
    /// in step time is constant from then on.
    fn stays(&self, index: Option<usize>, step: &StepTime, model: &Model) -> Option<f64> {
        let in_total_time = |a: &Amplitude| matches!(a.definition, AmplitudeDefinition::Curve { total_time: true, .. });
        let index = index.filter(|&i| !in_total_time(&model.amplitudes[i]))?;
        self.amplitude(Some(index), step.duration, model)
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

    fn settled_load(&self, load: &Load, step: &StepTime, model: &mut Model) -> Load {
        let mut settled = load.clone();
        if let Some(factor) = self.stays(load.amplitude, step, model) {
            // The user's routine is told the amplitude, and applies it itself.
            if matches!(load.kind, LoadKind::User { .. } | LoadKind::UserBody { .. }) {
                settled.amplitude = Some(constant(factor, load.amplitude, model));
            } else {
                (settled.magnitude, settled.amplitude) = (load.magnitude * factor, None);
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

    /// A displacement counts from where its nodes are: what its amplitude begins with is taken off.
    fn counted_from_place(&self, mut b: Boundary, model: &mut Model) -> Boundary {
        if b.kind != Motion::Displacement || b.user {
            return b;
        }
        let first = self.amplitude(b.amplitude, 0.0, model);
        if let (Some(index), Some(first)) = (b.amplitude, first.filter(|f| *f != 0.0)) {
            let mut shifted = model.amplitudes[index].clone();
            if let AmplitudeDefinition::Curve { points, .. } = &mut shifted.definition {
                points.iter_mut().for_each(|p| p[1] -= first);
            }
            b.amplitude = Some(push(shifted, model));
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

    /// Magnitudes of loads as the step begins, by place.
    fn magnitudes(&self, loads: &[Load], model: &Model) -> HashMap<Place, f64> {
        let mut before = HashMap::new();
        for load in loads {
            let value = self.amplitude(load.amplitude, 0.0, model).unwrap_or(0.0) * load.magnitude;
            for place in places(&load.kind) {
                *before.entry(place).or_default() += value;
            }
        }
        before
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

fn push(amplitude: Amplitude, model: &mut Model) -> usize {
    model.amplitudes.push(amplitude);
    model.amplitudes.len() - 1
}

/// An amplitude that stays at what another came to.
fn constant(factor: f64, other: Option<usize>, model: &mut Model) -> usize {
    let (name, span) = other.map_or_else(Default::default, |i| {
        let other = &model.amplitudes[i];
        (other.name.clone(), other.span)
    });
    let definition = AmplitudeDefinition::Curve { points: vec![[0.0, factor]], smooth: false, total_time: false };
    push(Amplitude { name, definition, absolute: false, span }, model)
}

/// Value and amplitude of what grows linearly over a step from one value to another.
fn ramp(from: f64, to: f64, span: Span, step: &StepTime, model: &mut Model) -> (f64, Option<usize>) {
    if from == to {
        return (to, None);
    }
    let value = if to == 0.0 { from } else { to };
    let points = vec![[0.0, from / value], [step.duration, to / value]];
    let definition = AmplitudeDefinition::Curve { points, smooth: false, total_time: false };
    (value, Some(push(Amplitude { name: RAMP.into(), definition, absolute: false, span }, model)))
}

/// Whether two boundaries say the same of a degree of freedom.
fn same_condition(a: &Boundary, b: &Boundary) -> bool {
    let holds = |b: &Boundary| {
        let ignored = b.kind == Motion::Displacement && b.amplitude.is_none();
        !b.user && b.kind != Motion::Acceleration && (b.value == 0.0 || ignored)
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

/// Where a load acts, and of which kind it is: what a later step replaces.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Place {
    Node(usize, u8),
    /// A side of an element (`*DLOAD`) under a kind of load.
    Face(usize, Side, Kind),
    /// A surface (`*DSLOAD`), upper case, under a kind of load.
    Surface(String, Kind),
    Body(usize, i32),
    Gravity(Option<Vec<usize>>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Pressure,
    User(i32),
    Cavity(usize),
}

fn places(kind: &LoadKind) -> Vec<Place> {
    let on = |sides: &Sides, kind: Kind| match sides.surface {
        true => vec![Place::Surface(upper(&sides.name), kind)],
        false => sides.faces.iter().map(|&(e, side)| Place::Face(e, side, kind)).collect(),
    };
    match kind {
        LoadKind::Concentrated { nodes, dof, .. } => nodes.iter().map(|&n| Place::Node(n, *dof)).collect(),
        LoadKind::Gravity { elements, .. } => vec![Place::Gravity(elements.clone())],
        LoadKind::Pressure(sides) => on(sides, Kind::Pressure),
        LoadKind::User { sides, load_type } => on(sides, Kind::User(*load_type)),
        LoadKind::Cavity { sides, target, .. } => on(sides, Kind::Cavity(*target)),
        LoadKind::UserBody { elements, load_type, .. } => {
            elements.iter().map(|&e| Place::Body(e, *load_type)).collect()
        }
    }
}

/// Takes loads of earlier steps from the places where a step gives others of their kind.
fn replace_loads(inherited: &mut Vec<Load>, given: &[Load]) {
    let taken: HashSet<Place> = given.iter().flat_map(|l| places(&l.kind)).collect();
    let kept = |load: &mut Load| {
        let mut keep =
            places(&load.kind).into_iter().map(|place| !taken.contains(&place)).collect::<Vec<_>>().into_iter();
        let mut next = || keep.next().unwrap_or(true);
        match &mut load.kind {
            LoadKind::Concentrated { nodes: list, .. } | LoadKind::UserBody { elements: list, .. } => {
                list.retain(|_| next());
                !list.is_empty()
            }
            LoadKind::Pressure(s) | LoadKind::User { sides: s, .. } | LoadKind::Cavity { sides: s, .. }
                if !s.surface =>
            {
                s.faces.retain(|_| next());
                !s.faces.is_empty()
            }
            _ => next(),
        }
    };
    inherited.retain_mut(kept);
}

/// What to say of loads of one kind at one place in one step: they add.
fn added_loads(given: &[Load]) -> Vec<Diagnostic> {
    let mut first: HashMap<Place, Span> = HashMap::new();
    let mut words = Vec::new();
    for load in given {
        let mut told = false;
        for place in places(&load.kind) {
            let earlier = *first.entry(place).or_insert(load.span);
            if earlier != load.span && !told {
                let message = "a load of this kind is given at the same place by another line of this step: they add";
                let finding = Diagnostic::warning("M144", message).at(load.span, "the later");
                words.push(finding.at(earlier, "the earlier"));
                told = true;
            }
        }
    }
    words
}

/// A load without amplitude that grows linearly over the step from what it was at its beginning; in parts, where that differs.
fn ramped_load(load: Load, before: &HashMap<Place, f64>, step: &StepTime, model: &mut Model) -> Vec<Load> {
    let scaled = matches!(load.kind, LoadKind::Concentrated { .. } | LoadKind::Gravity { .. } | LoadKind::Pressure(_));
    if load.amplitude.is_some() || !scaled {
        return vec![load];
    }
    let from: Vec<u64> = places(&load.kind).iter().map(|p| before.get(p).copied().unwrap_or(0.0).to_bits()).collect();
    let mut values = from.clone();
    values.sort_unstable();
    values.dedup();
    let part = |&bits: &u64| {
        let mut part = load.clone();
        let mut own = from.iter().map(|&b| b == bits);
        let mut next = || own.next().unwrap_or(true);
        match &mut part.kind {
            LoadKind::Concentrated { nodes, .. } => nodes.retain(|_| next()),
            LoadKind::Pressure(sides) if !sides.surface => sides.faces.retain(|_| next()),
            _ => {}
        }
        (part.magnitude, part.amplitude) = ramp(f64::from_bits(bits), load.magnitude, load.span, step, model);
        part
    };
    values.iter().map(part).collect()
}
