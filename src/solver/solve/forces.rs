//! Evaluation of an instant: forces of elements, loads and ties, and the accelerations that follow from them.

use std::ops::Range;

use super::central_difference::accelerate_nodes;
use super::guard::not_finite;
use super::masses::scale_masses;
use super::merging::merge_free_nodes;
use super::run::SolverRun;
use super::run_state::RunState;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::tie::TiedNodes;
use crate::constraint::{of_kind, of_kind_mut};
use crate::element::user_field::NodalFieldInput;
use crate::element::volume_guard::{STARTING, guard_start};
use crate::kernel::lanes::InlineMap;
use crate::load::{LoadForces, SceneChange, SceneView, TargetDissipation};
use crate::plan::State;
use crate::state::BodyState;
use crate::state::halt::HaltReason;
use crate::state::magnitude::AmplitudeClock;

impl SolverRun<'_> {
    /// Evaluates forces and accelerations outside the increments: at the start of a step, or on a new mesh.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    #[inline(never)]
    pub(super) fn evaluate_accelerations(&mut self) -> Result<(), HaltReason> {
        self.evaluate_forces()?;
        self.accelerate()
    }

    #[inline(always)]
    pub(super) fn evaluate_forces(&mut self) -> Result<(), HaltReason> {
        if !self.current.state.dofs.nodes.is_empty() {
            self.evaluate_nodes()?;
        }
        let is_at_rest = |body: &BodyState| body.direction == 0.0;
        if self.current.state.dofs.bodies.iter().any(is_at_rest) {
            self.evaluate_resting_bodies()
        } else {
            self.apply_body_loads(0..self.current.state.loads.len())
        }
    }

    /// Evaluates the forces on bodies of which one is at rest: resistances act against the motion that the other forces
    /// would start.
    #[inline(never)]
    fn evaluate_resting_bodies(&mut self) -> Result<(), HaltReason> {
        let (first_resistance, loads) = (self.current.body_forces.first_resistance, self.current.state.loads.len());
        self.apply_body_loads(0..first_resistance)?;
        if first_resistance < loads {
            self.current.body_forces.turn_resting_bodies(&mut self.current.state.dofs.bodies);
            self.apply_body_loads(first_resistance..loads)?;
        }
        Ok(())
    }

    /// Evaluates the forces on bodies of a range of loads.
    #[inline(always)]
    pub(super) fn apply_body_loads(&mut self, range: Range<usize>) -> Result<(), HaltReason> {
        let RunState { state, now, velocity_extrapolation, body_forces, .. } = &mut self.current;
        let State { dofs, loads, user_amplitudes, .. } = state;
        let clock = AmplitudeClock { now: *now, user_amplitudes };
        let velocity_extrapolation = *velocity_extrapolation;
        let view = SceneView { clock, dofs, velocity_extrapolation, rings: None, element_force: None };
        let mut start = body_forces.start_of(range.start);
        for (load, &(row, end)) in loads[range.clone()].iter_mut().zip(&body_forces.loads[range]) {
            let started = self.timing.start(row);
            let forces = &mut body_forces.values[start..end];
            load.apply(&view, &mut self.user.routines, &mut LoadForces::OnBodies(forces))?;
            self.timing.stop(started, row);
            start = end;
        }
        Ok(())
    }

    /// Evaluates element stresses, forces of loads and links on nodes, and the forces of tied nodes on bodies.
    #[inline(never)]
    fn evaluate_nodes(&mut self) -> Result<(), HaltReason> {
        self.scale_masses();
        let is_fresh = self.current.state.elements.is_pending();
        if is_fresh {
            self.give_fields()?;
            self.apply_temperatures();
        }
        let State { elements, dofs, .. } = &mut self.current.state;
        elements.update(dofs, &self.current.now, self.threads, self.user.routines.at_points(), self.timing.groups());
        if self.current.state.thermal.is_some() {
            self.conduct(is_fresh);
        }
        self.current.state.dofs.nodes.begin_forces();
        self.release_faces();
        self.apply_nodal_loads()?;
        let State { elements, dofs, .. } = &mut self.current.state;
        elements.add_link_forces(dofs);
        elements.check(&dofs.nodes).map_err(|collapsed| self.report.collapsed(&self.current, collapsed))?;
        self.transfer_to_bodies();
        Ok(())
    }

    /// Scales masses if due, and records the places of the added mass.
    fn scale_masses(&mut self) {
        if let (Some(places), Some(summary)) = (scale_masses(&mut self.current), self.report.outcome.steps.last_mut()) {
            (summary.added_mass, summary.added_mass_at) = (Some(places.total()), Some(places));
        }
    }

    /// Sets element temperatures and removes thermal strains.
    #[inline(never)]
    fn apply_temperatures(&mut self) {
        let State { elements, dofs, thermal, user_amplitudes, .. } = &mut self.current.state;
        let Some(thermal) = thermal else { return };
        let started = thermal.heat.as_ref().map(|heat| (self.timing.start(heat.id), heat.id));
        thermal.prepare_elements(elements, dofs, &AmplitudeClock { now: self.current.now, user_amplitudes });
        if let Some((started, id)) = started {
            self.timing.stop(started, id);
        }
    }

    /// Sets prescribed temperatures and field variables of elements.
    #[inline(never)]
    fn give_fields(&mut self) -> Result<(), HaltReason> {
        let RunState { state, now, last_increment, .. } = &mut self.current;
        let State { elements, user_amplitudes, dofs, .. } = state;
        let Some(id) = elements.fields.as_ref().map(|f| f.id) else { return Ok(()) };
        let started = self.timing.start(id);
        let routine = self.user.routines.nodal_fields.as_deref_mut();
        let input = NodalFieldInput { dofs, increment: *last_increment, routine };
        let result = elements.give_fields(&AmplitudeClock { now: *now, user_amplitudes }, input);
        self.timing.stop(started, id);
        result
    }

    /// Adds the heat of plastic work and evaluates heat conduction.
    #[inline(never)]
    fn conduct(&mut self, is_fresh: bool) {
        let State { elements, dofs, thermal, constraints, user_amplitudes, .. } = &mut self.current.state;
        let Some(heat) = thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
        let started = self.timing.start(heat.id);
        if is_fresh {
            heat.collect_plastic_heat(elements);
        }
        let clock = AmplitudeClock { now: self.current.now, user_amplitudes };
        heat.evaluate(elements, dofs, constraints, &clock, self.threads);
        self.timing.stop(started, heat.id);
    }

    /// Sums the forces of tied nodes on their rigid bodies.
    fn transfer_to_bodies(&mut self) {
        let State { elements, dofs, constraints, .. } = &self.current.state;
        let force = |n: usize| {
            let ([r, z], more) =
                (elements.assembly.node_force(n), dofs.nodes.forces[0].get(n).copied().unwrap_or_default());
            [r + more[0], z + more[1]]
        };
        for (tie, sum) in of_kind::<TiedNodes>(constraints).zip(&mut self.current.body_forces.values) {
            *sum = tie.force(force);
        }
    }

    /// Informs loads, constraints and heat about the elements that were deleted in this increment.
    fn release_faces(&mut self) {
        let State { elements, loads, constraints, thermal, .. } = &mut self.current.state;
        let deleted = elements.deletions.newly_deleted();
        if !deleted.is_empty() {
            loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::DeletedElements(deleted)));
            of_kind_mut::<ContactConstraint>(constraints).for_each(|contact| contact.remove_elements(deleted));
            if let Some(heat) = thermal.as_mut().and_then(|t| t.heat.as_mut()) {
                heat.release(deleted);
            }
        }
    }

    fn apply_nodal_loads(&mut self) -> Result<(), HaltReason> {
        let RunState { state, now, velocity_extrapolation, .. } = &mut self.current;
        let State { elements, dofs, loads, user_amplitudes, .. } = state;
        // Taken out of the state, because loads read the state.
        let mut forces = std::mem::take(&mut dofs.nodes.forces[0]);
        let mut dissipated = TargetDissipation::default();
        let rings = elements.assembly.ring_factors();
        let element_force =
            |n: usize| elements.assembly.node_force(n).inline_map(|f| rings.map_or(f, |rings| rings[n] * f));
        let view = SceneView {
            clock: AmplitudeClock { now: *now, user_amplitudes },
            dofs,
            velocity_extrapolation: *velocity_extrapolation,
            rings,
            element_force: Some(&element_force),
        };
        let mut result = Ok(());
        for load in loads {
            let started = self.timing.start(load.effect());
            match load.apply(&view, &mut self.user.routines, &mut LoadForces::OnNodes(&mut forces)) {
                Ok(work) => dissipated.add(work),
                Err(halt) => {
                    result = Err(halt);
                    break;
                }
            }
            self.timing.stop(started, load.effect());
        }
        dofs.nodes.forces[0] = forces;
        let TargetDissipation { cavity, friction } = dissipated;
        dofs.energies.cavity += cavity;
        dofs.energies.friction += friction;
        dofs.energies.external += cavity + friction;
        result
    }

    #[inline(always)]
    pub(super) fn accelerate(&mut self) -> Result<(), HaltReason> {
        let RunState { state, step, plan, body_forces, .. } = &mut self.current;
        let State { dofs, elements, .. } = state;
        let mut start = 0;
        for b in 0..dofs.bodies.len() {
            let body = &mut dofs.bodies[b];
            let slots = &body_forces.order_by_body[start..start + body.slots as usize];
            start += slots.len();
            let forces = slots.iter().map(|&(coordinate, i)| (coordinate, body_forces.values[i]));
            if body.accelerate(forces) {
                body_forces.arrest(b);
            }
        }
        let has_nodes = !dofs.nodes.is_empty();
        if has_nodes {
            let row = plan.rows.gather.unwrap_or_default();
            let started = self.timing.start(row);
            accelerate_nodes(elements, dofs, &mut self.kinetic);
            self.timing.stop(started, row);
        }
        if step.merges_detached_nodes {
            merge_free_nodes(&mut self.current);
        }
        let RunState { state, now, step, .. } = &mut self.current;
        let State { dofs, elements, constraints, user_amplitudes, .. } = state;
        for constraint in constraints {
            constraint.accelerations(dofs, &AmplitudeClock { now: *now, user_amplitudes });
        }
        dofs.nodes.work_pending = false;
        // A fixed increment ignores the stable time increment.
        if has_nodes && now.increment < STARTING && !step.is_fixed() {
            guard_start(&elements.groups, &mut elements.limit, &dofs.nodes);
        }
        if dofs.bodies.iter().all(|b| b.acceleration.abs() < f64::INFINITY) {
            Ok(())
        } else {
            Err(not_finite(&self.current))
        }
    }
}
