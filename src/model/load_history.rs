//! What the loads of several steps come to: which one acts at a place, how large it is, and what goes on into the next step
//! (ABAQUS Analysis User's Guide 34.1.2 and 34.4.1). Never here: cards, boundaries.

use std::collections::{HashMap, HashSet};

use super::history::{History, StepTime, constant, ramp};
use super::names::upper;
use super::types::{Load, LoadKind, Model, Side, Sides, TargetId};
use crate::deck::{Diagnostic, Span};

impl History {
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
        if let LoadKind::Film { coefficient, amplitude, .. } = &mut settled.kind
            && let Some(factor) = self.stays(*amplitude, step, model)
        {
            (*coefficient, *amplitude) = (*coefficient * factor, None);
        }
        settled
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
    NodalHeat(usize),
    BodyHeat(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Pressure,
    User(i32),
    Cavity(TargetId),
    Heat,
    Film,
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
        LoadKind::NodalHeat { nodes, .. } => nodes.iter().map(|&n| Place::NodalHeat(n)).collect(),
        LoadKind::SurfaceHeat(sides) => on(sides, Kind::Heat),
        LoadKind::BodyHeat { elements, .. } => elements.iter().map(|&e| Place::BodyHeat(e)).collect(),
        LoadKind::Film { sides, .. } => on(sides, Kind::Film),
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
            LoadKind::Concentrated { nodes: list, .. }
            | LoadKind::UserBody { elements: list, .. }
            | LoadKind::NodalHeat { nodes: list, .. }
            | LoadKind::BodyHeat { elements: list, .. } => {
                list.retain(|_| next());
                !list.is_empty()
            }
            LoadKind::Pressure(s)
            | LoadKind::SurfaceHeat(s)
            | LoadKind::User { sides: s, .. }
            | LoadKind::Film { sides: s, .. }
            | LoadKind::Cavity { sides: s, .. }
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
    let scaled = matches!(
        load.kind,
        LoadKind::Concentrated { .. }
            | LoadKind::Gravity { .. }
            | LoadKind::Pressure(_)
            | LoadKind::NodalHeat { .. }
            | LoadKind::SurfaceHeat(_)
            | LoadKind::BodyHeat { .. }
    );
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
            LoadKind::Concentrated { nodes: list, .. }
            | LoadKind::NodalHeat { nodes: list, .. }
            | LoadKind::BodyHeat { elements: list, .. } => list.retain(|_| next()),
            LoadKind::Pressure(sides) | LoadKind::SurfaceHeat(sides) if !sides.surface => {
                sides.faces.retain(|_| next())
            }
            _ => {}
        }
        (part.magnitude, part.amplitude) = ramp(f64::from_bits(bits), load.magnitude, load.span, step, model);
        part
    };
    values.iter().map(part).collect()
}
