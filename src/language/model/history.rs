//! Propagation of boundary conditions over steps: which condition controls a node, its magnitude, and its continuation
//! in the next step (ABAQUS Analysis User's Guide 34.1.2, "Continuation of an amplitude reference in subsequent steps",
//! and 34.3.1).

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::types::{
    Amplitude, AmplitudeDefinition, AmplitudeId, BoundaryCondition, Load, Model, MotionKind, PrescribedField,
};
use crate::deck::{Diagnostic, Diagnostics, Span};
use crate::kernel::amplitude::AmplitudeCurve;

/// Relative difference of displacements up to which a prescribed displacement does not jump.
const JUMP: f64 = 1e-9;
/// Name of the amplitudes created for `*STEP, AMPLITUDE=RAMP`.
const RAMP: &str = "RAMP";

/// Node index and degree of freedom.
type NodeDof = (usize, u8);

/// Conditions and state passed from earlier steps to the next one.
#[derive(Clone, Debug, Default)]
pub(super) struct StepHistory {
    /// Boundary conditions in force, with the values that they keep in the next step.
    pub boundaries: Vec<BoundaryCondition>,
    /// Loads in force, with the magnitudes that they keep in the next step.
    pub loads: Vec<Load>,
    /// Field variables in force, with the values that they keep in the next step.
    pub fields: Vec<PrescribedField>,
    /// Total time at the start of the next step.
    time: f64,
    /// Prescribed displacements that are known in advance; all are zero before the first step.
    places: HashMap<NodeDof, f64>,
    /// Initial amplitude values of the displacements in force, by data line.
    first_values: HashMap<(Span, AmplitudeId), f64>,
    /// Whether a step has ended.
    begun: bool,
}

/// Time data of the current step.
pub(super) struct StepTiming {
    /// Step duration, time.
    pub duration: f64,
    /// Whether conditions without amplitude increase linearly over the step (`*STEP, AMPLITUDE=RAMP`).
    pub ramp: bool,
}

impl StepHistory {
    /// Returns the boundary conditions in force in a step that defines `given`, and stores those that continue in the
    /// next step.
    pub fn boundaries(
        &mut self,
        given: Vec<BoundaryCondition>,
        step: &StepTiming,
        model: &mut Model,
        diagnostics: &mut Diagnostics,
    ) -> Vec<BoundaryCondition> {
        let added = if step.ramp { self.ramped_boundaries(given, step, model) } else { given };
        let spans: HashSet<Span> = added.iter().map(|b| b.span).collect();
        let merged = merge_boundaries(std::mem::take(&mut self.boundaries), added, diagnostics);
        let mut carried = merged.clone();
        for b in &mut carried {
            self.settle((&mut b.value, &mut b.amplitude), b.user, step, model);
        }
        self.boundaries = carried;
        let places = self.displacements_after(&merged, step, model);
        self.first_values.retain(|(span, _), _| !spans.contains(span));
        let mut in_force = Vec::with_capacity(merged.len());
        for b in merged {
            self.unknown_start(&b, model).into_iter().for_each(|d| diagnostics.push(d));
            if spans.contains(&b.span) {
                self.jump(&b, model).into_iter().for_each(|d| diagnostics.push(d));
            }
            in_force.push(self.relative_to_start(b, model));
        }
        self.places = places;
        in_force
    }

    /// Stores boundary conditions defined before the first step, which are in force from then on.
    pub fn model_data(&mut self, given: Vec<BoundaryCondition>, diagnostics: &mut Diagnostics) {
        self.boundaries = merge_boundaries(Vec::new(), given, diagnostics);
    }

    /// Advances the total time by the duration of a step that has been read.
    pub fn end(&mut self, step: &StepTiming) {
        self.time += step.duration;
        self.begun = true;
    }

    /// Returns the value of an amplitude at a step time; `None` for a user amplitude.
    pub(super) fn amplitude(&self, amplitude: Option<AmplitudeId>, step_time: f64, model: &Model) -> Option<f64> {
        let Some(id) = amplitude else { return Some(1.0) };
        let curve = curve(&model.amplitudes[id])?;
        Some(curve.value(if curve.total_time { self.time + step_time } else { step_time }))
    }

    /// Returns the constant factor of an amplitude after its step; `None` if the amplitude continues. Amplitudes in
    /// total time and user amplitudes continue; amplitudes in step time keep their last value.
    fn factor_after_step(&self, amplitude: Option<AmplitudeId>, step: &StepTiming, model: &Model) -> Option<f64> {
        let in_total_time = |a: &Amplitude| matches!(a.definition, AmplitudeDefinition::Curve { total_time: true, .. });
        let id = amplitude.filter(|&id| !in_total_time(&model.amplitudes[id]))?;
        self.amplitude(Some(id), step.duration, model)
    }

    /// Sets a magnitude and its amplitude to those in the next step. A user subroutine receives the amplitude and applies it.
    pub(super) fn settle(
        &self,
        (magnitude, amplitude): (&mut f64, &mut Option<AmplitudeId>),
        is_user: bool,
        step: &StepTiming,
        model: &mut Model,
    ) {
        match self.factor_after_step(*amplitude, step, model) {
            Some(factor) if is_user => *amplitude = Some(constant(factor, *amplitude, model)),
            Some(factor) => (*magnitude, *amplitude) = (*magnitude * factor, None),
            None => {}
        }
    }

    /// Returns the displacements at the end of a step that are known in advance.
    fn displacements_after(
        &self,
        boundaries: &[BoundaryCondition],
        step: &StepTiming,
        model: &Model,
    ) -> HashMap<NodeDof, f64> {
        let mut places = HashMap::new();
        for b in boundaries.iter().filter(|b| !b.user) {
            let ends = [0.0, step.duration].map(|t| self.amplitude(b.amplitude, t, model));
            let moved = match (b.kind, b.value, ends) {
                (MotionKind::Displacement, value, [Some(first), Some(last)]) => value * (last - first),
                (MotionKind::Velocity, 0.0, _) => 0.0,
                _ => continue,
            };
            for &node in &b.nodes {
                if let Some(place) = self.initial_displacement((node, b.dof)) {
                    places.insert((node, b.dof), place + moved);
                }
            }
        }
        places
    }

    /// Returns the displacement at the start of the step if it is known in advance.
    fn initial_displacement(&self, dof: NodeDof) -> Option<f64> {
        if self.begun { self.places.get(&dof).copied() } else { Some(0.0) }
    }

    /// Reports a displacement with a user amplitude that continues in a later step, where its initial value is unknown.
    fn unknown_start(&self, b: &BoundaryCondition, model: &Model) -> Option<Diagnostic> {
        let routine = self.amplitude(b.amplitude, 0.0, model).is_none();
        if !(self.begun && routine && b.kind == MotionKind::Displacement && !b.user) {
            return None;
        }
        let message = "a displacement with a user amplitude is not supported beyond the first step";
        let diagnostic = Diagnostic::error("M104", message).at(b.span, "in force in a later step");
        Some(diagnostic.help("prescribe a velocity, or use *BOUNDARY, USER"))
    }

    /// Reports a displacement that does not start at the current displacement of its nodes.
    fn jump(&self, b: &BoundaryCondition, model: &Model) -> Option<Diagnostic> {
        let first = self.amplitude(b.amplitude, 0.0, model)? * b.value;
        if b.kind != MotionKind::Displacement || b.user || b.amplitude.is_none() || b.value == 0.0 {
            return None;
        }
        let places: Vec<Option<f64>> = b.nodes.iter().map(|&n| self.initial_displacement((n, b.dof))).collect();
        if places.contains(&None) {
            let message = format!(
                "the displacement of `{}` at the start of the step is not known in advance; \
                 the prescribed displacement is measured from there",
                b.set
            );
            return Some(
                Diagnostic::note("M147", message).at(b.span, "the nodes were free or had another motion before"),
            );
        }
        let jumps = |place: &f64| (first - place).abs() > JUMP * (first.abs() + b.value.abs());
        let displacement = places.into_iter().flatten().find(jumps)?;
        let message = format!(
            "the displacement of `{}` would jump from {displacement} to {first} at the start of the step; the jump is ignored, \
             and the motion continues from {displacement}",
            b.set
        );
        let diagnostic = Diagnostic::warning("M146", message).at(b.span, "as ABAQUS/Explicit does");
        Some(diagnostic.help("let the amplitude start at the current displacement of the nodes"))
    }

    /// Converts a displacement to one relative to the position of the nodes when it starts: the initial value of its
    /// amplitude is subtracted, also in later steps in which it continues.
    fn relative_to_start(&mut self, mut b: BoundaryCondition, model: &mut Model) -> BoundaryCondition {
        if b.kind != MotionKind::Displacement || b.user {
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
            b.amplitude = Some(add_amplitude(shifted, model));
        }
        b
    }

    /// Returns boundary conditions without amplitude as linear ramps from their values at the start of the step.
    fn ramped_boundaries(
        &self,
        given: Vec<BoundaryCondition>,
        step: &StepTiming,
        model: &mut Model,
    ) -> Vec<BoundaryCondition> {
        let mut values_before: HashMap<(NodeDof, MotionKind), f64> = HashMap::new();
        for b in &self.boundaries {
            let value = self.amplitude(b.amplitude, 0.0, model).unwrap_or(0.0) * b.value;
            values_before.extend(b.nodes.iter().map(|&n| (((n, b.dof), b.kind), value)));
        }
        let from = |node: usize, b: &BoundaryCondition| match b.kind {
            MotionKind::Displacement => self.initial_displacement((node, b.dof)).unwrap_or(0.0),
            kind => values_before.get(&((node, b.dof), kind)).copied().unwrap_or(0.0),
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
                ramped.push(BoundaryCondition { nodes, value, amplitude, ..b.clone() });
            }
        }
        ramped
    }
}

fn curve(amplitude: &Amplitude) -> Option<AmplitudeCurve> {
    match &amplitude.definition {
        AmplitudeDefinition::Curve { points, smooth, total_time } => {
            Some(AmplitudeCurve::new(points.clone(), *smooth, *total_time))
        }
        AmplitudeDefinition::User { .. } => None,
    }
}

/// Returns the handle of an amplitude and adds it if there is no equal one, so that unchanged conditions remain equal.
fn add_amplitude(amplitude: Amplitude, model: &mut Model) -> AmplitudeId {
    let known = model.amplitudes.iter().position(|a| *a == amplitude);
    AmplitudeId::new(known.unwrap_or_else(|| {
        model.amplitudes.push(amplitude);
        model.amplitudes.len() - 1
    }))
}

/// Returns a constant amplitude with the given factor and the name of another.
fn constant(factor: f64, other: Option<AmplitudeId>, model: &mut Model) -> AmplitudeId {
    let (name, span) = other.map_or_else(Default::default, |i| {
        let other = &model.amplitudes[i];
        (other.name.clone(), other.span)
    });
    let definition = AmplitudeDefinition::Curve { points: vec![[0.0, factor]], smooth: false, total_time: false };
    add_amplitude(Amplitude { name, definition, absolute: false, span }, model)
}

/// Returns magnitude and amplitude of a linear ramp over a step.
pub(super) fn ramp(from: f64, to: f64, span: Span, step: &StepTiming, model: &mut Model) -> (f64, Option<AmplitudeId>) {
    if from == to {
        return (to, None);
    }
    let value = if to == 0.0 { from } else { to };
    let points = vec![[0.0, from / value], [step.duration, to / value]];
    let definition = AmplitudeDefinition::Curve { points, smooth: false, total_time: false };
    (value, Some(add_amplitude(Amplitude { name: RAMP.into(), definition, absolute: false, span }, model)))
}

/// Returns whether two boundary conditions prescribe the same motion or both hold the node.
fn same_condition(a: &BoundaryCondition, b: &BoundaryCondition) -> bool {
    let holds = |b: &BoundaryCondition| {
        let ignored = b.kind == MotionKind::Displacement && b.amplitude.is_none();
        !b.user && !matches!(b.kind, MotionKind::Acceleration | MotionKind::Temperature) && (b.value == 0.0 || ignored)
    };
    holds(a) && holds(b)
        || (a.kind, a.user, a.value.to_bits(), a.amplitude) == (b.kind, b.user, b.value.to_bits(), b.amplitude)
}

/// Merges inherited and new boundary conditions. A later condition overrides earlier ones at its nodes. Conflicting
/// conditions in the same step are reported.
fn merge_boundaries(
    inherited: Vec<BoundaryCondition>,
    given: Vec<BoundaryCondition>,
    diagnostics: &mut Diagnostics,
) -> Vec<BoundaryCondition> {
    let inherited_count = inherited.len();
    let conditions: Vec<BoundaryCondition> = inherited.into_iter().chain(given).collect();
    // Index of the last condition of each degree of freedom.
    let mut last: HashMap<NodeDof, usize> = HashMap::new();
    for (i, b) in conditions.iter().enumerate() {
        let mut reported = false;
        for &node in &b.nodes {
            let holder = last.entry((node, b.dof)).or_insert(i);
            let earlier = &conditions[*holder];
            if *holder == i
                || same_condition(earlier, b)
                    && (*holder >= inherited_count || i < inherited_count || earlier.nodes != b.nodes)
            {
                continue;
            }
            if *holder >= inherited_count && !reported && !same_condition(earlier, b) {
                diagnostics.push(given_twice(earlier, b));
                reported = true;
            }
            *holder = i;
        }
    }
    let trimmed = conditions.into_iter().enumerate().map(|(i, mut b)| {
        b.nodes.retain(|&n| last.get(&(n, b.dof)).is_none_or(|&holder| holder <= i));
        b
    });
    trimmed.filter(|b| !b.nodes.is_empty()).collect()
}

fn given_twice(earlier: &BoundaryCondition, later: &BoundaryCondition) -> Diagnostic {
    let message = format!(
        "`{}` and `{}` prescribe different values for degree of freedom {} \
         of shared nodes in this step; the later is used",
        earlier.set, later.set, later.dof
    );
    Diagnostic::warning("M145", message).at(later.span, "later condition").at(earlier.span, "earlier condition")
}
