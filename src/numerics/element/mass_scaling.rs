//! Mass scaling (`*FIXED MASS SCALING`, `*VARIABLE MASS SCALING`): requests, the factor of each element, and when
//! factors are recomputed.

use crate::kernel::lists::{Memory, heap_bytes};
use crate::kernel::topology::PerNode;
use crate::state::archive::Persist;

/// Rule that derives mass factors from a target stable time increment (`TYPE`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingTarget {
    /// Elements with a smaller stable time increment are raised to the target.
    BelowMin,
    /// One factor for the whole set, from its smallest stable time increment.
    Uniform,
    /// Every element is set to the target, up or down.
    SetEqual,
}

/// Mass scaling of a set of elements: a factor, a target stable time increment, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalingRequest {
    /// Group and element index of the scaled elements.
    pub elements: Vec<(usize, usize)>,
    /// Factor on the mass, applied before the target increment.
    pub factor: f64,
    /// Scaling rule and target stable time increment.
    pub aim: Option<(ScalingTarget, f64)>,
    /// Largest mass that [`ScalingTarget::BelowMin`] adds, as a fraction of the mass without it.
    pub budget: Option<f64>,
}

/// Interval between evaluations of variable mass scaling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScalingInterval {
    /// Number of increments of the step.
    Increments(u64),
    /// Step time.
    Time(f64),
}

/// Variable mass scaling, with its interval and the next due increment or interval of the step.
#[derive(Clone, Debug, PartialEq, Persist)]
#[persist(derived: request, rhythm)]
pub struct VariableScaling {
    /// Elements and scaling rule.
    pub request: ScalingRequest,
    pub rhythm: ScalingInterval,
    due: u64,
}

impl VariableScaling {
    /// Creates variable mass scaling that is first due at the start of the step.
    pub fn new(request: ScalingRequest, rhythm: ScalingInterval) -> Self {
        VariableScaling { request, rhythm, due: 0 }
    }

    /// Returns whether scaling is due at this instant, and if so advances to the next interval.
    pub(super) fn take_if_due(&mut self, increment: u64, step_time: f64) -> bool {
        let (reached, next) = match self.rhythm {
            ScalingInterval::Increments(every) => (increment >= self.due, increment + every),
            ScalingInterval::Time(every) => (step_time >= self.due as f64 * every, (step_time / every) as u64 + 1),
        };
        if reached {
            self.due = next;
        }
        reached
    }
}

/// Requests of fixed and variable mass scaling of one step.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
#[persist(fixed: variable; derived: fixed)]
pub struct StepMassScaling {
    /// Requests evaluated once, at the start of the step; `None` if those of an earlier step continue.
    pub fixed: Option<Vec<ScalingRequest>>,
    pub variable: Vec<VariableScaling>,
    /// Increment in which the step began.
    pub(super) first: Option<u64>,
}

impl StepMassScaling {
    /// Creates the scaling of a step that has not begun.
    pub fn new(fixed: Option<Vec<ScalingRequest>>, variable: Vec<VariableScaling>) -> Self {
        StepMassScaling { fixed, variable, first: None }
    }
}

/// Masses without scaling and factors of a group with a new mesh, in the order of its elements.
#[derive(Clone, Debug, Default)]
pub struct ArrivedScaling {
    /// Corner masses without scaling.
    pub masses: Vec<[f64; 4]>,
    /// Factor of fixed requests, and product of all factors.
    pub factors: Vec<[f64; 2]>,
    /// Nodes with point masses, which are not scaled.
    pub points: Vec<(usize, f64)>,
}

/// Masses without scaling, and the factors on them. All lists are allocated here, so that nothing allocates inside an
/// increment.
#[derive(Clone, Debug, Persist, Memory)]
// The set of linked nodes follows from the plan; scaled masses are recomputed.
#[persist(fixed: nodes; fixed_lists: elements, fixed, factors, applied; derived: linked, sums, rates)]
#[memory(inside: elements, fixed, factors, applied)]
pub struct ScaledMasses {
    pub(super) nodes: Vec<f64>,
    /// Masses of elements at their nodes, by group.
    pub(super) elements: Vec<Vec<PerNode<f64>>>,
    /// Nodes with equations or links; empty if there are none.
    pub(super) linked: Vec<bool>,
    /// Factors of fixed requests, and products of all factors.
    pub(super) fixed: Vec<Vec<f64>>,
    pub(super) factors: Vec<Vec<f64>>,
    /// Factors that are applied to the elements.
    pub(super) applied: Vec<Vec<f64>>,
    /// Scaled masses of the nodes.
    pub(super) sums: Vec<f64>,
    /// Work array: inverse of the stable time increment and mass of each element of a request with a target.
    pub(super) rates: Vec<[f64; 2]>,
    /// Sum of the masses of the nodes without scaling, and the mass that scaling has added.
    pub(super) original: f64,
    pub(super) added: f64,
    /// The part of the added mass at linked nodes.
    pub(super) added_to_links: f64,
}

/// Mass scaling of a model.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(present: masses)]
pub struct MassScaling {
    /// Unscaled masses and mass factors; `None` without mass scaling.
    pub(super) masses: Option<Box<ScaledMasses>>,
}

impl MassScaling {
    /// Returns the bytes of the lists.
    pub fn bytes(&self) -> usize {
        self.masses.as_ref().map_or(0, |masses| masses.bytes())
    }
}

/// Mass added by scaling to nodes that are not nodes of rigid bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AddedMass {
    /// Mass without scaling.
    pub original: f64,
    /// All added mass.
    pub added: f64,
    /// The part of the added mass at nodes with equations or links.
    pub linked: f64,
}

impl StepMassScaling {
    /// Begins a step that continues this scaling: requests by time were evaluated at the end of the previous step.
    pub fn begin_step(&mut self) {
        let by_time = self.variable.iter_mut().filter(|v| matches!(v.rhythm, ScalingInterval::Time(_)));
        by_time.for_each(|variable| variable.due = 1);
    }

    pub fn bytes(&self) -> usize {
        let bytes_of = |r: &ScalingRequest| size_of_val(r) + heap_bytes(&r.elements);
        self.fixed.iter().flatten().map(bytes_of).sum::<usize>()
            + self.variable.iter().map(|v| bytes_of(&v.request)).sum::<usize>()
    }
}

impl ScaledMasses {
    /// Returns the masses of an element at its nodes, scaled by a factor.
    pub(super) fn scaled(&self, group: usize, element: usize, factor: f64) -> PerNode<f64> {
        let mut masses = self.elements[group][element];
        masses.iter_mut().for_each(|mass| *mass *= factor);
        masses
    }
}
