//! Mean reaction forces over the output interval: the impulse of a constraint since the last row, divided by the time since
//! then. The integral of the written forces over time is the impulse for any interval.
//!
//! In an increment the forces at its start act until the middle, and the forces at its end act from there, as in the
//! output velocity. So the impulse of a row belongs to the change of momentum by the velocities of the rows.

use super::run_state::RunState;
use crate::constraint::ConstraintIndex;
use crate::plan::{ColumnSource, Plan};
use crate::state::archive::Persist;
use crate::state::dofs::Dof;
use crate::variables::{Variable, VariableComponent};

/// Impulse of the reaction on a degree of freedom since the last row, and the mean over the interval of that row.
#[derive(Clone, Debug, Persist)]
#[persist(derived: dof, prescribed, constraints)]
struct ReactionMean {
    dof: Dof,
    /// Whether its motion is prescribed in the step.
    prescribed: bool,
    /// Indices of the constraints that act on the degree of freedom, each with its index in the constraint.
    constraints: Vec<(usize, usize)>,
    /// Impulse of complete increments.
    impulse: f64,
    /// Impulse of the last motion until the middle of its increment.
    opening: f64,
    /// Impulse from that middle to the current instant.
    closing: f64,
    mean: f64,
    /// Total time from which on impulses count: that of the last row or of a new mesh.
    since: f64,
}

/// Impulses of the reactions that have history columns, in the order of the degrees of freedom.
#[derive(Clone, Debug, Default, Persist)]
#[persist(fixed: reactions)]
pub(super) struct ReactionMeans {
    reactions: Vec<ReactionMean>,
    /// Last increment whose impulses have been added.
    added: u64,
}

impl ReactionMeans {
    pub(super) fn new(plan: &Plan) -> ReactionMeans {
        let members = |source| match source {
            ColumnSource::Set(_, index) => plan.sets[index].clone(),
            source => vec![source],
        };
        let columns = plan.columns.iter().filter_map(|column| Some((column.part?, column.source)));
        let sources = columns.flat_map(|(part, source)| members(source).into_iter().map(move |source| (part, source)));
        let mut dofs: Vec<Dof> = sources.filter_map(|(part, source)| reaction_dof(source, part)).collect();
        dofs.sort_unstable();
        dofs.dedup();
        let reactions = dofs.into_iter().map(ReactionMean::new).collect();
        ReactionMeans { reactions, ..ReactionMeans::default() }
    }

    /// Finds the constraints of the step that act on each degree of freedom.
    pub(super) fn begin_step(&mut self, run: &RunState<'_>) {
        let index = ConstraintIndex::new(&run.state.constraints);
        for reaction in &mut self.reactions {
            let (constraints, is_prescribed) = index.acting_on(reaction.dof);
            reaction.constraints = constraints;
            reaction.prescribed = match reaction.dof {
                Dof::Body(b) => run.state.dofs.bodies[b].prescribed && run.state.dofs.bodies[b].stations().is_none(),
                Dof::Node(..) => is_prescribed,
            };
        }
    }

    /// Computes the impulses of the motion that has led to a new instant, before that instant is evaluated.
    #[inline(always)]
    pub(super) fn add_motion(&mut self, run: &RunState<'_>) {
        if !self.reactions.is_empty() {
            self.open(run);
        }
    }

    #[inline(never)]
    fn open(&mut self, run: &RunState<'_>) {
        for reaction in &mut self.reactions {
            reaction.opening = reaction.impulse_of_motion(run);
        }
    }

    /// Adds the impulses of the increment that leads to the current instant, once.
    #[inline(always)]
    pub(super) fn add_instant(&mut self, run: &RunState<'_>) {
        if !self.reactions.is_empty() && self.added != run.now.increment {
            self.added = run.now.increment;
            self.close(run);
        }
    }

    #[inline(never)]
    fn close(&mut self, run: &RunState<'_>) {
        for reaction in &mut self.reactions {
            reaction.closing = reaction.closing_impulse(run);
            reaction.impulse += reaction.opening + reaction.closing;
        }
    }

    /// Computes the means at a row. A second row at the same instant repeats the first one.
    pub(super) fn begin_row(&mut self, total_time: f64) {
        for reaction in &mut self.reactions {
            let interval = total_time - std::mem::replace(&mut reaction.since, total_time);
            if interval > 0.0 {
                reaction.mean = std::mem::take(&mut reaction.impulse) / interval;
            }
        }
    }

    /// Adds the impulses with which constraints complete the velocities of bodies before a new mesh: those of half an
    /// increment.
    pub(super) fn add_completion(&mut self, run: &RunState<'_>) {
        let nodes = &run.state.dofs.nodes;
        let is_body = |reaction: &&mut ReactionMean| reaction.prescribed && matches!(reaction.dof, Dof::Body(_));
        for reaction in self.reactions.iter_mut().filter(is_body).filter(|_| nodes.half > 0.0) {
            reaction.impulse -= 0.5 * nodes.previous_dt / nodes.half * reaction.of_constraints(run, nodes.half);
        }
    }

    /// Continues after a new mesh: with the impulses of bodies since the last row, and those of nodes from now on.
    pub(super) fn follow(&mut self, previous: &ReactionMeans, total_time: f64) {
        self.added = previous.added;
        for reaction in &mut self.reactions {
            let same = |known: &&ReactionMean| known.dof == reaction.dof && matches!(known.dof, Dof::Body(_));
            (reaction.impulse, reaction.mean, reaction.since) = match previous.reactions.iter().find(same) {
                Some(previous) => (previous.impulse, previous.mean, previous.since),
                None => (0.0, 0.0, total_time),
            };
        }
    }

    /// Returns the mean reaction of a column; `None` for another variable.
    pub(super) fn value(&self, source: ColumnSource, part: VariableComponent) -> Option<f64> {
        let dof = reaction_dof(source, part)?;
        let index = self.reactions.binary_search_by_key(&dof, |reaction| reaction.dof).ok()?;
        Some(self.reactions[index].mean)
    }
}

impl ReactionMean {
    fn new(dof: Dof) -> ReactionMean {
        let (prescribed, constraints) = (false, Vec::new());
        ReactionMean { dof, prescribed, constraints, impulse: 0.0, opening: 0.0, closing: 0.0, mean: 0.0, since: 0.0 }
    }

    /// Returns the impulse of the last motion until the middle of its increment.
    fn impulse_of_motion(&self, run: &RunState<'_>) -> f64 {
        let dofs = &run.state.dofs;
        match self.dof {
            _ if !self.prescribed => -self.closing_of_node(),
            Dof::Body(b) => {
                let body = &dofs.bodies[b];
                let gained = body.mass * (body.velocity_half - body.before.velocity);
                gained - 0.5 * run.last_increment * body.force - self.of_constraints(run, dofs.nodes.half)
            }
            Dof::Node(node, axis) => {
                let half = dofs.nodes.half;
                let gained = half * dofs.nodes.mass[node] * dofs.nodes.acceleration[node][axis];
                gained - self.of_constraints(run, half) - self.closing
            }
        }
    }

    /// Returns the closing impulse of a node, which the next motion contains again.
    fn closing_of_node(&self) -> f64 {
        if let Dof::Node(..) = self.dof { self.closing } else { 0.0 }
    }

    fn of_constraints(&self, run: &RunState<'_>, half: f64) -> f64 {
        let impulse = |&(i, index): &(usize, usize)| {
            run.state.constraints[i].forces().map_or(0.0, |c| c.impulse(self.dof, index, half))
        };
        self.constraints.iter().map(impulse).sum()
    }

    /// Returns the impulse from the middle of the last increment to the current instant.
    fn closing_impulse(&self, run: &RunState<'_>) -> f64 {
        let (dofs, half) = (&run.state.dofs, 0.5 * run.last_increment);
        match self.dof {
            _ if !self.prescribed => 0.0,
            Dof::Body(b) => {
                let body = &dofs.bodies[b];
                body.mass * (body.velocity - body.velocity_half) - half * body.force
            }
            Dof::Node(node, axis) => {
                let force = |&(i, index): &(usize, usize)| {
                    run.state.constraints[i].forces().map_or(0.0, |c| c.current_force(self.dof, index))
                };
                let forces: f64 = self.constraints.iter().map(force).sum();
                half * (dofs.nodes.mass[node] * dofs.nodes.acceleration[node][axis] - forces)
            }
        }
    }
}

/// Returns the degree of freedom of a column of reactions; `None` for another variable, and for radial reactions of rigid
/// bodies, which balance around the axis.
fn reaction_dof(source: ColumnSource, part: VariableComponent) -> Option<Dof> {
    match (part.variable, source) {
        (Variable::Reaction | Variable::ReactionMoment, ColumnSource::Node(node)) => {
            Some(Dof::Node(node, part.component))
        }
        (Variable::Reaction, ColumnSource::Body { body, .. }) if part.component == 1 => Some(Dof::Body(body)),
        _ => None,
    }
}
