//! Steps of the plan: compares each step with the previous one and creates only the effects that change.

use std::collections::HashSet;
use std::rc::Rc;

use crate::constraint::Constraint;
use crate::constraint::bonds::PrescribedDofs;
use crate::constraint::user_motion::UserMotion;
use crate::element::mass_scaling::StepMassScaling;
use crate::load::{Load, VelocityUse};
use crate::model::{
    self, AnalyticalFront, BoundaryCondition, EnergyLimit, IncrementControl, LoadKind, MassScaling, Model,
    ScalingSchedule, Step, SurfaceContact,
};
use crate::plan::changes::{ListChange, ListEntry};
use crate::plan::checks::overlaps::overlapping_bodies;
use crate::plan::constraints::equations::link_constraint;
use crate::plan::constraints::motions::add_motions;
use crate::plan::contact::contact_constraint;
use crate::plan::loads::{LoadInput, create_load};
use crate::plan::meshes::adaptive::adaptive_change;
use crate::plan::output::{RecordingState, output_schedules};
use crate::plan::solids::mass_scaling::{check_merging_step, check_scalable_step, mass_scaling};
use crate::plan::{
    GeneralLedgerRows, Links, Pairs, Report, Scene, SolidPlaces, State, StepChanges, StepInput, StepPlan,
};
use crate::state::dofs::Dof;

/// Active effects of the last compiled step, by their origin in the model.
#[derive(Default)]
struct ActiveEffects<'a> {
    loads: Vec<(&'a model::Load, VelocityUse)>,
    constraints: Vec<ConstraintOrigin<'a>>,
    /// Fronts of the analytical surfaces in contact of all compiled steps.
    fronts: Vec<AnalyticalFront>,
}

/// Origin of a constraint in the model. Constraints with equal origins are equal.
pub enum ConstraintOrigin<'a> {
    /// A line of `*BOUNDARY`, and the degrees of freedom that it prescribes.
    Motion(&'a BoundaryCondition, Vec<Dof>),
    /// Degrees of freedom on the axis of symmetry.
    Axis(Vec<Dof>),
    /// Links and equations, with the degrees of freedom that are prescribed.
    Equations(PrescribedDofs),
    /// Contact pairs, the prescribed degrees of freedom, and whether nodes without elements are removed from contact.
    Contact(Rc<Vec<SurfaceContact>>, HashSet<(usize, usize)>, bool),
    /// Check of bodies without contact for overlap.
    Overlaps,
    /// Deformable nodes tied to a rigid body, by index.
    Tie(usize),
}

impl ConstraintOrigin<'_> {
    fn is_same(&self, other: &ConstraintOrigin<'_>) -> bool {
        match (self, other) {
            (ConstraintOrigin::Motion(a, dofs), ConstraintOrigin::Motion(b, others)) => {
                prescribes_same(a, b) && dofs == others
            }
            (ConstraintOrigin::Axis(a), ConstraintOrigin::Axis(b)) => a == b,
            (ConstraintOrigin::Equations(a), ConstraintOrigin::Equations(b)) => a == b,
            (ConstraintOrigin::Contact(a, given, drops), ConstraintOrigin::Contact(b, others, drop)) => {
                (Rc::ptr_eq(a, b) || a == b) && given == others && drops == drop
            }
            (ConstraintOrigin::Overlaps, ConstraintOrigin::Overlaps) => true,
            (ConstraintOrigin::Tie(a), ConstraintOrigin::Tie(b)) => a == b,
            _ => false,
        }
    }

    /// Returns whether a constraint takes over the history of a previous one: the same boundary condition, or contact.
    fn continues(&self, previous: &ConstraintOrigin<'_>) -> bool {
        match (self, previous) {
            (ConstraintOrigin::Motion(a, _), ConstraintOrigin::Motion(b, _)) => {
                a.span == b.span && prescribes_same(a, b)
            }
            (ConstraintOrigin::Contact(..), ConstraintOrigin::Contact(..)) => true,
            _ => false,
        }
    }

    fn is_users(&self) -> bool {
        matches!(self, ConstraintOrigin::Motion(boundary, _) if boundary.user)
    }

    /// Returns the prescribed degrees of freedom, and whether they are fixed.
    fn prescribes(&self) -> (&[Dof], bool) {
        match self {
            ConstraintOrigin::Motion(boundary, dofs) => {
                (dofs, !boundary.user && crate::plan::constraints::motions::holds(boundary))
            }
            ConstraintOrigin::Axis(dofs) => (dofs, true),
            _ => (&[], false),
        }
    }
}

/// Returns whether two boundary conditions prescribe the same motion, on whatever nodes.
fn prescribes_same(a: &BoundaryCondition, b: &BoundaryCondition) -> bool {
    (a.dof, a.kind, a.user, a.value, a.amplitude) == (b.dof, b.kind, b.user, b.value, b.amplitude) && a.set == b.set
}

/// Returns whether two boundary conditions are equal except for their place in the deck.
fn is_same_boundary(a: &BoundaryCondition, b: &BoundaryCondition) -> bool {
    prescribes_same(a, b) && a.nodes == b.nodes
}

fn is_same_load(a: &model::Load, b: &model::Load) -> bool {
    (a.magnitude, a.amplitude) == (b.magnitude, b.amplitude) && a.kind == b.kind
}

/// Returns whether a load takes over the history of the load that it replaces: the tunnel in a target, or the data of a
/// user subroutine.
fn continues_load(load: &model::Load, previous: &model::Load) -> bool {
    match (&load.kind, &previous.kind) {
        (LoadKind::Cavity { target: a, .. }, LoadKind::Cavity { target: b, .. }) => a == b,
        (LoadKind::User { load_type: a, .. }, LoadKind::User { load_type: b, .. }) => a == b,
        _ => false,
    }
}

/// Builder of the constraints of a step: kept ones of the previous step, and new ones.
pub struct ConstraintList<'a> {
    previous: Vec<ConstraintOrigin<'a>>,
    origins: Vec<ConstraintOrigin<'a>>,
    entries: Vec<ListEntry<dyn Constraint>>,
    user_motions: Vec<ListEntry<UserMotion>>,
}

impl<'a> ConstraintList<'a> {
    /// Keeps the constraint of the previous step with the same origin. Returns the origin as an error if no constraint
    /// has it.
    pub fn keep(&mut self, origin: ConstraintOrigin<'a>) -> Result<(), ConstraintOrigin<'a>> {
        let Some(index) = self.previous.iter().position(|b| b.is_same(&origin)) else { return Err(origin) };
        if origin.is_users() {
            self.user_motions.push(ListEntry::Kept(self.previous[..index].iter().filter(|b| b.is_users()).count()));
        }
        self.entries.push(ListEntry::Kept(index));
        self.origins.push(origin);
        Ok(())
    }

    pub fn add(&mut self, origin: ConstraintOrigin<'a>, effect: Box<dyn Constraint>) {
        let places = (0..self.previous.len()).filter(|&i| origin.continues(&self.previous[i]));
        self.entries.push(ListEntry::Added { effect, continues: places.collect() });
        self.origins.push(origin);
    }

    /// Adds the user motion of the constraint that is added next.
    pub fn add_user_motion(&mut self, motion: UserMotion) {
        self.user_motions.push(ListEntry::Added { effect: Box::new(motion), continues: Vec::new() });
    }

    /// Returns the nodal degrees of freedom that are prescribed so far.
    fn given(&self) -> PrescribedDofs {
        let mut prescribed = PrescribedDofs::default();
        for (dofs, holds) in self.origins.iter().map(ConstraintOrigin::prescribes) {
            for &dof in dofs {
                let Dof::Node(node, axis) = dof else { continue };
                prescribed.all.insert((node, axis));
                if holds {
                    prescribed.held.insert((node, axis));
                }
            }
        }
        prescribed
    }
}

/// The steps of a plan.
pub struct PlannedSteps {
    pub list: Vec<StepPlan>,
    /// Fronts of analytical surfaces in contact, which new meshes keep.
    pub fronts: Vec<AnalyticalFront>,
    /// The state with the effects of the first step.
    pub state: State,
}

/// Compiles all steps.
pub fn plan(scene: Scene, links: &Links, pairs: &Pairs, state: RecordingState, report: &mut Report) -> PlannedSteps {
    let (mut active, mut state) = (ActiveEffects::default(), state.into_state());
    let mut steps = Vec::with_capacity(scene.model.steps.len());
    for (index, step) in scene.model.steps.iter().enumerate() {
        let input = StepInput { scene, links, pairs, state: &state, index };
        let loads = load_changes(input, &mut active, report);
        let (constraints, user_motions) = constraint_changes(input, &mut active, report);
        let scaling = scaling_change(input, loads.is_some(), report);
        let adaptive = adaptive_change(scene, links, pairs, index, &mut state, report);
        let mut changes = StepChanges { loads, constraints, user_motions, scaling, adaptive };
        if index == 0 {
            state.begin_with(std::mem::take(&mut changes));
        }
        check_merging_step(scene.model, step, report);
        increment_rows(scene.places, step, &active, report);
        steps.push(StepPlan {
            name: step.name.clone(),
            duration: step.duration,
            control: step.increment,
            scale_factor: step.scale_factor,
            load_velocity: step.load_velocity,
            merges_detached_nodes: step.merges_detached_nodes(),
            changes,
            energy_limit: energy_limit(step, report),
            outputs: output_schedules(scene.model, step, report),
        });
    }
    PlannedSteps { list: steps, fronts: active.fronts, state }
}

/// Updates the loads of compiled steps from the current model, which has no links and no contact.
pub fn replan_loads(scene: Scene, steps: &mut [StepPlan], state: &mut State, report: &mut Report) {
    let (links, pairs) = (&Links::default(), &Pairs::default());
    let mut active = ActiveEffects::default();
    for (index, plan) in steps.iter_mut().enumerate() {
        let input = StepInput { scene, links, pairs, state, index };
        let loads = load_changes(input, &mut active, report);
        if index == 0 {
            state.loads = loads.map_or_else(Vec::new, ListChange::into_first);
        } else {
            plan.changes.loads = loads;
        }
        increment_rows(scene.places, &scene.model.steps[index], &active, report);
    }
}

/// Returns the step before the one at `index`; `None` for the first step.
fn step_before(model: &Model, index: usize) -> Option<&Step> {
    Some(&model.steps[index.checked_sub(1)?])
}

/// Returns the changes of the loads; those that resist motion are last.
fn load_changes<'a>(
    input: StepInput<'a, '_>,
    active: &mut ActiveEffects<'a>,
    report: &mut Report,
) -> Option<ListChange<dyn Load>> {
    let StepInput { scene, links, state, index, .. } = input;
    let (step, previous) = (&scene.model.steps[index], step_before(scene.model, index));
    // Resistance loads depend on the accuracy of the increment control.
    let same_pace = previous.is_some_and(|p| p.increment == step.increment);
    if same_pace && previous.is_some_and(|p| p.loads == step.loads) {
        return None;
    }
    let previous_loads = std::mem::take(&mut active.loads);
    let mut loads = Vec::with_capacity(step.loads.len());
    for load in &step.loads {
        let is_kept = |b: &(&model::Load, VelocityUse)| {
            (same_pace || !matches!(load.kind, LoadKind::Cavity { .. })) && is_same_load(b.0, load)
        };
        let (velocity, entry) = match previous_loads.iter().position(is_kept) {
            Some(index) => {
                report.share_ledger_rows(previous_loads[index].0.span, load.span);
                (previous_loads[index].1, ListEntry::Kept(index))
            }
            None => {
                let Some(effect) = create_load(&LoadInput { scene, links, load, step, state }, report) else {
                    continue;
                };
                let continues =
                    (0..previous_loads.len()).filter(|&i| continues_load(load, previous_loads[i].0)).collect();
                (effect.velocity_use(), ListEntry::Added { effect, continues })
            }
        };
        loads.push(((load, velocity), entry));
    }
    loads.sort_by_key(|((_, velocity), _)| *velocity == VelocityUse::Resists);
    let (origins, entries): (Vec<_>, Vec<_>) = loads.into_iter().unzip();
    active.loads = origins;
    ListChange::between(previous_loads.len(), entries)
}

fn constraint_changes<'a>(
    input: StepInput<'a, '_>,
    active: &mut ActiveEffects<'a>,
    report: &mut Report,
) -> (Option<ListChange<dyn Constraint>>, Option<ListChange<UserMotion>>) {
    let StepInput { scene, links, pairs, index, .. } = input;
    if keeps_constraints(input) {
        return (None, None);
    }
    let step = &scene.model.steps[index];
    let previous = std::mem::take(&mut active.constraints);
    let (entries, user_motions) = (Vec::new(), Vec::new());
    let mut list = ConstraintList { previous, origins: Vec::new(), entries, user_motions };
    add_motions(scene, step, &mut list, report);
    let prescribed = list.given();
    if let Err(origin) = list.keep(ConstraintOrigin::Equations(prescribed.clone()))
        && let Some(equations) = link_constraint(input, &prescribed, report)
    {
        list.add(origin, equations);
    }
    // Ties are added after contact, because tied nodes follow the motion of a rigid body after contact.
    let drops_points = step.excludes_detached_nodes();
    if let Err(origin) =
        list.keep(ConstraintOrigin::Contact(pairs.by_step[index].clone(), prescribed.all.clone(), drops_points))
        && let Some((contact, mut fronts)) = contact_constraint(input, &prescribed.all, report)
    {
        list.add(origin, contact);
        fronts.retain(|front| !active.fronts.contains(front));
        active.fronts.extend(fronts);
    }
    if let Err(origin) = list.keep(ConstraintOrigin::Overlaps)
        && let Some(overlaps) = overlapping_bodies(input, report).filter(|_| index == 0)
    {
        list.add(origin, overlaps);
    }
    for (i, tie) in links.rigid_ties.iter().enumerate() {
        if let Err(origin) = list.keep(ConstraintOrigin::Tie(i)) {
            list.add(origin, Box::new(tie.clone()));
        }
    }
    let previous_motions = list.previous.iter().filter(|b| b.is_users()).count();
    active.constraints = list.origins;
    let constraints = ListChange::between(list.previous.len(), list.entries);
    (constraints, ListChange::between(previous_motions, list.user_motions))
}

/// Returns whether all constraints of a step have the same origins as those of the previous step.
fn keeps_constraints(input: StepInput) -> bool {
    let StepInput { scene, pairs, index, .. } = input;
    let (step, Some(previous)) = (&scene.model.steps[index], step_before(scene.model, index)) else { return false };
    let (boundaries, others) = (&step.boundaries, &previous.boundaries);
    boundaries.len() == others.len()
        && boundaries.iter().zip(others).all(|(a, b)| is_same_boundary(a, b))
        && Rc::ptr_eq(&pairs.by_step[index], &pairs.by_step[index - 1])
        && step.excludes_detached_nodes() == previous.excludes_detached_nodes()
}

/// Returns the mass scaling of a step; `None` if the one of the previous step continues.
fn scaling_change(input: StepInput, loads_change: bool, report: &mut Report) -> Option<Option<StepMassScaling>> {
    let StepInput { scene, index, .. } = input;
    let (step, previous) = (&scene.model.steps[index], step_before(scene.model, index));
    let intervals = |s: &MassScaling| matches!(s.schedule, Some(ScalingSchedule::Intervals(_)));
    let same_pace = |p: &Step| p.duration == step.duration || !step.mass_scalings.iter().any(intervals);
    if step.mass_scalings[..] == *previous.map_or(&[][..], |p| &p.mass_scalings) && previous.is_none_or(same_pace) {
        if loads_change && !step.mass_scalings.is_empty() {
            check_scalable_step(step, report);
        }
        return None;
    }
    Some(mass_scaling(input, report))
}

/// Creates the ledger rows of the increment control and of the velocity that is passed to loads.
fn increment_rows(places: &SolidPlaces, step: &Step, active: &ActiveEffects, report: &mut Report) {
    let mut detail = match step.increment {
        IncrementControl::Automatic { .. } if !places.elements.is_empty() => {
            format!("stable time increment times {}", step.scale_factor)
        }
        IncrementControl::Fixed(dt) => format!("fixed time increment {dt:e} (direct user control)"),
        IncrementControl::Automatic { accuracy, .. } if !places.nodes.is_empty() => {
            format!("time increment by error control of springs, dashpots and masses, accuracy {accuracy:e}")
        }
        IncrementControl::Automatic { accuracy, .. } => {
            format!("no stability limit; time increment by error control, accuracy {accuracy:e}")
        }
    };
    if let IncrementControl::Automatic { largest, .. } = step.increment
        && largest.is_finite()
    {
        detail += &format!(", at most {largest:e}");
    }
    report.ledger_row(step.span, "central difference", 1, "step", detail);
    if active.loads.iter().any(|(_, velocity)| *velocity != VelocityUse::None) {
        let scheme = match step.load_velocity {
            model::LoadVelocity::Predicted => "second-order extrapolation to the time of the increment",
            model::LoadVelocity::Lagged => "velocity of the previous half increment (LAGGED)",
        };
        report.ledger_row(step.span, "load velocity", 1, "step", scheme.into());
    }
}

fn energy_limit(step: &Step, report: &mut Report) -> Option<EnergyLimit> {
    let limit = step.energy_limit?;
    let part = |name: &str, value: Option<f64>| value.map(|v| format!("{name} {v:e}"));
    let parts: Vec<String> =
        [part("error", limit.error), part("artificial", limit.artificial)].into_iter().flatten().collect();
    let detail = format!("{}, {}", parts.join(", "), if limit.halts { "halt" } else { "warn" });
    report.ledger_row(limit.span, "energy limit", 1, "step", detail);
    Some(limit)
}

/// Creates the ledger rows that every analysis has, attributed to the first step.
pub fn integration_rows(scene: Scene, state: &State, shown: usize, report: &mut Report) -> GeneralLedgerRows {
    let Some(step) = scene.model.steps.first() else { return GeneralLedgerRows::default() };
    let integration = report.ledger_rows.get(&(step.span, "central difference")).copied();
    let nodes = state.dofs.nodes.len() - scene.places.rotations.len();
    let detail = "nodal forces, masses and motion";
    let gather = (nodes > 0).then(|| report.ledger_row(step.span, "nodes", nodes, "nodes", detail.into()));
    let detail = "mesh, frames, histories";
    let output = Some(report.ledger_row(step.span, "output", shown, "variables", detail.into()));
    GeneralLedgerRows { integration, gather, output }
}
