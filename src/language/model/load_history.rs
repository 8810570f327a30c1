//! Propagation of loads over steps: which load acts in a region, its magnitude, and its continuation in the next step
//! (ABAQUS Analysis User's Guide 34.1.2 and 34.4.1).

use std::collections::{HashMap, HashSet};

use super::history::{StepHistory, StepTiming, ramp};
use super::names::upper;
use super::types::{
    BodyForce, ElementSide, Load, LoadKind, LoadRegionMut, Model, SideSelection, SurfaceTraction, TargetId,
};
use crate::deck::{Diagnostic, Diagnostics, Span};

impl StepHistory {
    /// Returns the loads in force in a step that defines `given`, and stores those that continue in the next step.
    pub fn loads(
        &mut self,
        given: Vec<Load>,
        step: &StepTiming,
        model: &mut Model,
        diagnostics: &mut Diagnostics,
    ) -> Vec<Load> {
        let mut inherited = std::mem::take(&mut self.loads);
        let magnitudes_before = if step.ramp { self.magnitudes(&inherited, model) } else { HashMap::new() };
        replace_loads(&mut inherited, &given);
        added_loads(&given).into_iter().for_each(|d| diagnostics.push(d));
        let added: Vec<Load> = match step.ramp {
            true => given.into_iter().flat_map(|l| ramped_load(l, &magnitudes_before, step, model)).collect(),
            false => given,
        };
        inherited.extend(added);
        let mut carried = inherited.clone();
        for Load { kind, magnitude, amplitude, .. } in &mut carried {
            self.settle((magnitude, amplitude), kind.is_user(), step, model);
            if let LoadKind::Film { coefficient, amplitude, .. } = kind {
                self.settle((coefficient, amplitude), false, step, model);
            }
        }
        self.loads = carried;
        inherited
    }

    /// Returns the magnitudes of loads at the start of the step, by place.
    fn magnitudes(&self, loads: &[Load], model: &Model) -> HashMap<LoadPlace, f64> {
        let mut magnitudes = HashMap::new();
        for load in loads {
            let value = self.amplitude(load.amplitude, 0.0, model).unwrap_or(0.0) * load.magnitude;
            for place in places(&load.kind) {
                *magnitudes.entry(place).or_default() += value;
            }
        }
        magnitudes
    }
}

/// Place and type of a load. A load of a later step replaces loads at the same place.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum LoadPlace {
    Node(usize, u8),
    /// A face of an element (`*DLOAD`) and the type of load.
    Face(usize, ElementSide, LoadFamily),
    /// An upper-case surface name (`*DSLOAD`) and the type of load.
    Surface(String, LoadFamily),
    Body(usize, i32),
    BodyForce(usize, BodyForce),
    Gravity(Option<Vec<usize>>),
    NodalHeat(usize),
    BodyHeat(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum LoadFamily {
    Pressure,
    VectorTraction,
    ShearTraction,
    ViscousPressure,
    Blast,
    User(i32),
    Cavity(TargetId),
    Heat,
    Film,
}

impl LoadFamily {
    fn of_traction(law: &SurfaceTraction) -> LoadFamily {
        match law {
            SurfaceTraction::Vector { .. } => LoadFamily::VectorTraction,
            SurfaceTraction::Shear { .. } => LoadFamily::ShearTraction,
            SurfaceTraction::Viscous { .. } | SurfaceTraction::Absorbing { .. } => LoadFamily::ViscousPressure,
        }
    }
}

fn places(kind: &LoadKind) -> Vec<LoadPlace> {
    let on = |sides: &SideSelection, kind: LoadFamily| match sides.surface {
        true => vec![LoadPlace::Surface(upper(&sides.name), kind)],
        false => sides.faces.iter().map(|&(e, side)| LoadPlace::Face(e, side, kind)).collect(),
    };
    match kind {
        LoadKind::Concentrated { nodes, dof, .. } => nodes.iter().map(|&n| LoadPlace::Node(n, *dof)).collect(),
        LoadKind::Gravity { elements, .. } => vec![LoadPlace::Gravity(elements.clone())],
        LoadKind::Pressure(sides) => on(sides, LoadFamily::Pressure),
        LoadKind::Traction { sides, law } => on(sides, LoadFamily::of_traction(law)),
        LoadKind::Blast { sides, .. } => on(sides, LoadFamily::Blast),
        LoadKind::Body { elements, law, .. } => elements.iter().map(|&e| LoadPlace::BodyForce(e, *law)).collect(),
        LoadKind::User { sides, load_type } => on(sides, LoadFamily::User(*load_type)),
        LoadKind::Cavity { sides, target, .. } => on(sides, LoadFamily::Cavity(*target)),
        LoadKind::NodalHeat { nodes, .. } => nodes.iter().map(|&n| LoadPlace::NodalHeat(n)).collect(),
        LoadKind::SurfaceHeat(sides) => on(sides, LoadFamily::Heat),
        LoadKind::BodyHeat { elements, .. } => elements.iter().map(|&e| LoadPlace::BodyHeat(e)).collect(),
        LoadKind::Film { sides, .. } => on(sides, LoadFamily::Film),
        LoadKind::UserBody { elements, load_type, .. } => {
            elements.iter().map(|&e| LoadPlace::Body(e, *load_type)).collect()
        }
    }
}

/// Removes loads of earlier steps at the places for which the step defines loads of the same type.
fn replace_loads(inherited: &mut Vec<Load>, given: &[Load]) {
    let taken: HashSet<LoadPlace> = given.iter().flat_map(|l| places(&l.kind)).collect();
    let keeps_load = |load: &mut Load| {
        let mut keep =
            places(&load.kind).into_iter().map(|place| !taken.contains(&place)).collect::<Vec<_>>().into_iter();
        retain_places(&mut load.kind, || keep.next().unwrap_or(true))
    };
    inherited.retain_mut(keeps_load);
}

/// Keeps the places of a load, in the order of [`places`], for which `keeps` returns true. Returns whether one is left.
fn retain_places(kind: &mut LoadKind, mut keeps: impl FnMut() -> bool) -> bool {
    let is_gravity = matches!(kind, LoadKind::Gravity { .. });
    match kind.region_mut() {
        LoadRegionMut::Nodes(list) | LoadRegionMut::Elements(list) if !is_gravity => {
            list.retain(|_| keeps());
            !list.is_empty()
        }
        LoadRegionMut::Sides(sides) if !sides.surface => {
            sides.faces.retain(|_| keeps());
            !sides.faces.is_empty()
        }
        _ => keeps(),
    }
}

/// Reports loads of the same type at the same place in one step, which add up.
fn added_loads(given: &[Load]) -> Vec<Diagnostic> {
    let mut first: HashMap<LoadPlace, Span> = HashMap::new();
    let mut diagnostics = Vec::new();
    for load in given {
        let mut reported = false;
        for place in places(&load.kind) {
            let earlier = *first.entry(place).or_insert(load.span);
            if earlier != load.span && !reported {
                let message = "another data line of this step defines a load of this \
                               type at the same place; the loads add up";
                let diagnostic = Diagnostic::warning("M144", message).at(load.span, "later load");
                diagnostics.push(diagnostic.at(earlier, "earlier load"));
                reported = true;
            }
        }
    }
    diagnostics
}

/// Returns a load without amplitude as linear ramps over the step, one for each initial magnitude in its region.
fn ramped_load(load: Load, before: &HashMap<LoadPlace, f64>, step: &StepTiming, model: &mut Model) -> Vec<Load> {
    let scaled = matches!(
        load.kind,
        LoadKind::Concentrated { .. }
            | LoadKind::Gravity { .. }
            | LoadKind::Pressure(_)
            | LoadKind::Traction { .. }
            | LoadKind::Body { .. }
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
        let mut is_in_part = from.iter().map(|&b| b == bits);
        retain_places(&mut part.kind, || is_in_part.next().unwrap_or(true));
        (part.magnitude, part.amplitude) = ramp(f64::from_bits(bits), load.magnitude, load.span, step, model);
        part
    };
    values.iter().map(part).collect()
}
