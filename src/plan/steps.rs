//! Steps of the plan: what each changes of what is in force. What a step takes over unchanged is not made again.
//! Never here: how single effects are made.

use std::collections::HashSet;
use std::rc::Rc;

use super::changes::{Changes, Entry, ListChange};
use super::{Compiler, State, StepPlan};
use crate::constraint::Constraint;
use crate::constraint::bonds::Given;
use crate::constraint::user_motion::UserMotion;
use crate::deck::Span;
use crate::load::{Load, VelocityUse};
use crate::model::{self, Boundary, IncrementControl, LoadKind, MassScaling, ScalingRhythm, Step, SurfaceContact};
use crate::state::dofs::Dof;

/// What the step planned last has in force, by what each effect comes from.
#[derive(Default)]
pub(super) struct InForce<'a> {
    loads: Vec<(&'a model::Load, VelocityUse)>,
    constraints: Vec<Origin<'a>>,
}

/// What a constraint comes from: two that come from the same are the same.
pub(super) enum Origin<'a> {
    /// A line of `*BOUNDARY`, and the degrees of freedom that it prescribes.
    Motion(&'a Boundary, Vec<Dof>),
    /// Degrees of freedom on the axis of symmetry.
    Axis(Vec<Dof>),
    /// Links and equations beside these prescribed motions.
    Equations(Given),
    /// Pairs of surfaces, of which these degrees of freedom are prescribed, and whether nodes without elements meet nothing.
    Contact(Rc<Vec<SurfaceContact>>, HashSet<(usize, usize)>, bool),
    /// One of the contacts of bodies in space with walls, of these pairs beside these prescribed motions.
    Wall(Rc<Vec<SurfaceContact>>, HashSet<(usize, usize)>, usize),
    /// The look at bodies between which nothing acts.
    Overlaps,
    /// The nodes that a rigid body carries.
    Tie(usize),
}

impl Origin<'_> {
    fn is_same(&self, other: &Origin<'_>) -> bool {
        match (self, other) {
            (Origin::Motion(a, dofs), Origin::Motion(b, others)) => prescribes_same(a, b) && dofs == others,
            (Origin::Axis(a), Origin::Axis(b)) => a == b,
            (Origin::Equations(a), Origin::Equations(b)) => a == b,
            (Origin::Contact(a, given, drops), Origin::Contact(b, others, drop)) => {
                (Rc::ptr_eq(a, b) || a == b) && given == others && drops == drop
            }
            (Origin::Wall(a, given, i), Origin::Wall(b, others, j)) => {
                (Rc::ptr_eq(a, b) || a == b) && given == others && i == j
            }
            (Origin::Overlaps, Origin::Overlaps) => true,
            (Origin::Tie(a), Origin::Tie(b)) => a == b,
            _ => false,
        }
    }

    /// Whether a constraint takes over the memory of another: of the same line, or of the contact before.
    fn continues(&self, before: &Origin<'_>) -> bool {
        match (self, before) {
            (Origin::Motion(a, _), Origin::Motion(b, _)) => a.span == b.span && prescribes_same(a, b),
            (Origin::Contact(..), Origin::Contact(..)) => true,
            _ => false,
        }
    }

    fn is_users(&self) -> bool {
        matches!(self, Origin::Motion(boundary, _) if boundary.user)
    }

    /// Degrees of freedom of nodes that it prescribes, and whether it holds them.
    fn prescribes(&self) -> (&[Dof], bool) {
        match self {
            Origin::Motion(boundary, dofs) => (dofs, !boundary.user && super::motions::holds(boundary)),
            Origin::Axis(dofs) => (dofs, true),
            _ => (&[], false),
        }
    }
}

/// Whether two lines prescribe the same of their nodes, whichever these are.
fn prescribes_same(a: &Boundary, b: &Boundary) -> bool {
    (a.dof, a.kind, a.user, a.value, a.amplitude) == (b.dof, b.kind, b.user, b.value, b.amplitude) && a.set == b.set
}

/// Whether two lines are the same but for where they stand.
fn is_same_boundary(a: &Boundary, b: &Boundary) -> bool {
    prescribes_same(a, b) && a.nodes == b.nodes
}

fn is_same_load(a: &model::Load, b: &model::Load) -> bool {
    (a.magnitude, a.amplitude) == (b.magnitude, b.amplitude) && a.kind == b.kind
}

/// Whether a load takes over the memory of another, which it replaces: the tunnel in a target, what a routine was shown.
fn continues_load(load: &model::Load, before: &model::Load) -> bool {
    match (&load.kind, &before.kind) {
        (LoadKind::Cavity { target: a, .. }, LoadKind::Cavity { target: b, .. }) => a == b,
        (LoadKind::User { load_type: a, .. }, LoadKind::User { load_type: b, .. }) => a == b,
        _ => false,
    }
}

/// Constraints of a step in the making: those of the step before that stay, and new ones.
pub(super) struct ConstraintList<'a> {
    before: Vec<Origin<'a>>,
    origins: Vec<Origin<'a>>,
    entries: Vec<Entry<dyn Constraint>>,
    user_motions: Vec<Entry<UserMotion>>,
}

impl<'a> ConstraintList<'a> {
    /// Keeps what comes from the same in the step before; gives it back where that does not.
    pub(super) fn keep(&mut self, origin: Origin<'a>) -> Result<(), Origin<'a>> {
        let Some(place) = self.before.iter().position(|b| b.is_same(&origin)) else { return Err(origin) };
        if origin.is_users() {
            self.user_motions.push(Entry::Kept(self.before[..place].iter().filter(|b| b.is_users()).count()));
        }
        self.entries.push(Entry::Kept(place));
        self.origins.push(origin);
        Ok(())
    }

    pub(super) fn add(&mut self, origin: Origin<'a>, effect: Box<dyn Constraint>) {
        let places = (0..self.before.len()).filter(|&i| origin.continues(&self.before[i]));
        self.entries.push(Entry::Added { effect, continues: places.collect() });
        self.origins.push(origin);
    }

    /// Adds the questions that the motion added next follows.
    pub(super) fn ask(&mut self, motion: UserMotion) {
        self.user_motions.push(Entry::Added { effect: Box::new(motion), continues: Vec::new() });
    }

    /// What is prescribed of nodes so far.
    fn given(&self) -> Given {
        let mut given = Given::default();
        for (dofs, holds) in self.origins.iter().map(Origin::prescribes) {
            for &dof in dofs {
                let Dof::Node(node, axis) = dof else { continue };
                given.all.insert((node, axis));
                if holds {
                    given.held.insert((node, axis));
                }
            }
        }
        given
    }
}

impl<'a> Compiler<'a> {
    /// Plans all steps. What the first has in force becomes that of the state.
    pub(super) fn steps(&mut self, state: &mut State) -> Vec<StepPlan> {
        let mut steps = Vec::with_capacity(self.model.steps.len());
        for (index, step) in self.model.steps.iter().enumerate() {
            let mut changes = self.changes(index, state);
            if index == 0 {
                state.begin_with(std::mem::take(&mut changes));
            }
            self.increment_rows(step);
            steps.push(StepPlan {
                name: step.name.clone(),
                duration: step.duration,
                control: step.increment,
                scale_factor: step.scale_factor,
                load_velocity: step.load_velocity,
                changes,
                energy_limit: self.energy_limit(step),
                outputs: self.outputs(step),
            });
        }
        steps
    }

    /// Gives a step that has been planned the loads of its model as it is now.
    pub(super) fn reload(&mut self, index: usize, plan: &mut StepPlan, state: &mut State) {
        let loads = self.load_changes(index, state);
        if index == 0 {
            state.loads = loads.map_or_else(Vec::new, ListChange::into_first);
        } else {
            plan.changes.loads = loads;
        }
        self.increment_rows(&self.model.steps[index]);
    }

    fn changes(&mut self, index: usize, state: &State) -> Changes {
        let loads = self.load_changes(index, state);
        let (constraints, user_motions) = self.constraint_changes(index, state);
        let scaling = self.scaling_change(index, loads.is_some(), state);
        Changes { loads, constraints, user_motions, scaling }
    }

    /// The step before, where there is one.
    fn step_before(&self, index: usize) -> Option<&'a Step> {
        Some(&self.model.steps[index.checked_sub(1)?])
    }

    /// Loads of a step; those that resist come last.
    fn load_changes(&mut self, index: usize, state: &State) -> Option<ListChange<dyn Load>> {
        let (step, previous) = (&self.model.steps[index], self.step_before(index));
        // Increments of another accuracy let what resists go another way.
        let same_pace = previous.is_some_and(|p| p.increment == step.increment);
        if same_pace && previous.is_some_and(|p| p.loads == step.loads) {
            return None;
        }
        let before = std::mem::take(&mut self.in_force.loads);
        let mut loads = Vec::with_capacity(step.loads.len());
        for load in &step.loads {
            let is_kept = |b: &(&model::Load, VelocityUse)| {
                (same_pace || !matches!(load.kind, LoadKind::Cavity { .. })) && is_same_load(b.0, load)
            };
            let (velocity, entry) = match before.iter().position(is_kept) {
                Some(place) => {
                    self.share_rows(before[place].0.span, load.span);
                    (before[place].1, Entry::Kept(place))
                }
                None => {
                    let Some(effect) = self.load(load, step, state) else { continue };
                    let continues = (0..before.len()).filter(|&i| continues_load(load, before[i].0)).collect();
                    (effect.velocity_use(), Entry::Added { effect, continues })
                }
            };
            loads.push(((load, velocity), entry));
        }
        loads.sort_by_key(|((_, velocity), _)| *velocity == VelocityUse::Resists);
        let (origins, entries): (Vec<_>, Vec<_>) = loads.into_iter().unzip();
        self.in_force.loads = origins;
        ListChange::between(before.len(), entries)
    }

    fn constraint_changes(
        &mut self,
        index: usize,
        state: &State,
    ) -> (Option<ListChange<dyn Constraint>>, Option<ListChange<UserMotion>>) {
        if self.keeps_constraints(index) {
            return (None, None);
        }
        let step = &self.model.steps[index];
        let before = std::mem::take(&mut self.in_force.constraints);
        let (entries, user_motions) = (Vec::new(), Vec::new());
        let mut list = ConstraintList { before, origins: Vec::new(), entries, user_motions };
        self.motions(step, &mut list);
        let given = list.given();
        if let Err(origin) = list.keep(Origin::Equations(given.clone()))
            && let Some(equations) = self.equations(step, state, &given)
        {
            list.add(origin, equations);
        }
        // Tied nodes follow what contact does to a body that moves freely.
        let drops_points = step.general_contact.as_ref().is_some_and(|general| general.drops_points);
        if let Err(origin) = list.keep(Origin::Contact(self.pairs[index].clone(), given.all.clone(), drops_points))
            && let Some(contact) = self.contact(index, &given.all, state)
        {
            list.add(origin, contact);
        }
        let wall = |i: usize| Origin::Wall(self.pairs[index].clone(), given.all.clone(), i);
        let walls = self.pairs[index].iter().filter(|pair| self.spatial_side(pair).is_some()).count();
        let kept = (0..walls).take_while(|&i| list.keep(wall(i)).is_ok()).count();
        if kept < walls {
            let origins: Vec<Origin<'a>> = (0..walls).map(wall).collect();
            for (origin, contact) in origins.into_iter().zip(self.wall_contacts(index, state)).skip(kept) {
                list.add(origin, contact);
            }
        }
        if let Err(origin) = list.keep(Origin::Overlaps)
            && let Some(overlaps) = self.unpaired_bodies(state).filter(|_| index == 0)
        {
            list.add(origin, overlaps);
        }
        for (i, tie) in self.ties.iter().enumerate() {
            if let Err(origin) = list.keep(Origin::Tie(i)) {
                list.add(origin, Box::new(tie.clone()));
            }
        }
        let asked = list.before.iter().filter(|b| b.is_users()).count();
        self.in_force.constraints = list.origins;
        let constraints = ListChange::between(list.before.len(), list.entries);
        (constraints, ListChange::between(asked, list.user_motions))
    }

    /// Whether the constraints of a step come from the same as those of the step before.
    fn keeps_constraints(&self, index: usize) -> bool {
        let (step, Some(previous)) = (&self.model.steps[index], self.step_before(index)) else { return false };
        let (own, others) = (&step.boundaries, &previous.boundaries);
        let drops = |step: &Step| step.general_contact.as_ref().is_some_and(|general| general.drops_points);
        own.len() == others.len()
            && own.iter().zip(others).all(|(a, b)| is_same_boundary(a, b))
            && Rc::ptr_eq(&self.pairs[index], &self.pairs[index - 1])
            && drops(step) == drops(previous)
    }

    /// Mass scaling of a step; `None` where that of the step before goes on.
    fn scaling_change(
        &mut self,
        index: usize,
        loads_change: bool,
        state: &State,
    ) -> Option<Option<crate::element::mass_scaling::Scaling>> {
        let (step, previous) = (&self.model.steps[index], self.step_before(index));
        let scalings = |step: &'a Step| &step.mass_scalings[..];
        let intervals = |s: &MassScaling| matches!(s.rhythm, Some(ScalingRhythm::Intervals(_)));
        let same_pace = |p: &Step| p.duration == step.duration || !step.mass_scalings.iter().any(intervals);
        if scalings(step) == previous.map_or(&[][..], scalings) && previous.is_none_or(same_pace) {
            if loads_change && !step.mass_scalings.is_empty() {
                self.check_scalable_step(step);
            }
            return None;
        }
        Some(self.mass_scaling(index, state))
    }

    /// Rows of the ledger that one card asked for are asked for by another as well, which says the same.
    pub(super) fn share_rows(&mut self, first: Span, other: Span) {
        if first == other {
            return;
        }
        let asked_by = self.model.origin.sources.describe(other);
        let rows: Vec<(&'static str, usize)> = self
            .causes
            .iter()
            .filter(|((span, _), _)| *span == first)
            .map(|((_, effect), row)| (*effect, *row))
            .collect();
        for (effect, row) in rows {
            self.causes.entry((other, effect)).or_insert(row);
            let places = &mut self.ledger.effects[row].asked_by;
            if !places.contains(&asked_by) {
                places.push(asked_by.clone());
            }
        }
    }

    /// Rows of how a step chooses its increments and what velocity its loads are shown.
    fn increment_rows(&mut self, step: &Step) {
        let mut detail = match step.increment {
            IncrementControl::Automatic { .. } if !self.places.elements.is_empty() => {
                format!("stable increment times {}", step.scale_factor)
            }
            IncrementControl::Fixed(dt) => format!("fixed increment {dt:e} (direct user control)"),
            IncrementControl::Automatic { accuracy, .. } => {
                format!("nothing limits the increment: error estimate, accuracy {accuracy:e}")
            }
        };
        if let IncrementControl::Automatic { largest, .. } = step.increment
            && largest.is_finite()
        {
            detail += &format!(", at most {largest:e}");
        }
        self.cause(step.span, "central difference", 1, "step", detail);
        if self.in_force.loads.iter().any(|(_, velocity)| *velocity != VelocityUse::None) {
            let scheme = match step.load_velocity {
                model::LoadVelocity::Predicted => "second-order estimate at the increment's own time",
                model::LoadVelocity::Lagged => "mid-increment velocity behind (LAGGED)",
            };
            self.cause(step.span, "load velocity", 1, "step", scheme.into());
        }
    }
}
