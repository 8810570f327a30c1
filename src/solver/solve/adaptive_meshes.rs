//! Adaptive meshes in the time loop: they change after the length of the next increment is known and before the nodes
//! move.

use super::outcome::MeshChanges;
use super::run_state::RunState;
use super::timing::EffectTiming;
use crate::adaptive::AdaptiveDomain;
use crate::adaptive::smoothing::{BoundaryContact, Surroundings};
use crate::constraint::contact::ContactConstraint;
use crate::constraint::contact::curve::PointCarrier;
use crate::constraint::{Constraint, MeshMotion, of_kind, of_kind_mut, prescribed_motions};
use crate::element::elements::Elements;
use crate::heat::ThermalState;
use crate::kernel::chunks::ChunkLoops;
use crate::load::SceneChange;
use crate::plan::State;
use crate::state::Instant;
use crate::state::dofs::Dofs;
use crate::state::magnitude::AmplitudeClock;
use crate::variables::{Variable, VariableComponent};

/// Contact of the nodes of a domain, at the start of an increment of which only the motion of bodies has been made.
struct ContactSurroundings<'a> {
    constraints: &'a [Box<dyn Constraint>],
    dofs: &'a Dofs,
}

impl ContactSurroundings<'_> {
    fn contacts(&self) -> impl Iterator<Item = &ContactConstraint> {
        of_kind(self.constraints)
    }
}

impl Surroundings for ContactSurroundings<'_> {
    fn contact(&self, node: usize) -> BoundaryContact {
        let (carrier, opening) = (PointCarrier::Node(node), VariableComponent::from(Variable::ContactOpening));
        let mut nearest = f64::INFINITY;
        for contact in self.contacts() {
            if contact.is_pressed(carrier) == Some(true) {
                return BoundaryContact::Pressed;
            }
            // The opening is NaN where no surface is near.
            nearest = nearest.min(contact.value_at_point(carrier, opening).unwrap_or(f64::INFINITY));
        }
        BoundaryContact::Apart(nearest)
    }

    fn keeps_gaps(&self, node: usize) -> bool {
        self.contacts().any(|contact| contact.system.keeps_gaps(PointCarrier::Node(node)))
    }

    fn place_on_surface(&self, node: usize, place: [f64; 2]) -> Option<[f64; 2]> {
        let mut places = self.contacts().map(|c| c.system.place_on_surface(PointCarrier::Node(node), place, self.dofs));
        places.next().flatten()
    }
}

/// Adds the thermal strains of a domain at its current temperatures, times a sign, to those that have been applied.
fn take_thermal_strains(
    sign: f64,
    domain: &AdaptiveDomain,
    thermal: Option<&mut ThermalState>,
    elements: &mut Elements,
) {
    let Some(ThermalState { heat, expansion: Some(expansion) }) = thermal else { return };
    expansion.add_current(sign, domain.group(), heat.as_ref(), elements);
}

/// Returns the number of changes of a domain.
pub(super) fn changes_of(domain: &AdaptiveDomain) -> MeshChanges {
    MeshChanges { row: domain.id, count: domain.changes(), ..MeshChanges::default() }
}

/// New places of the nodes of all domains.
struct DomainMotion<'a>(&'a mut [AdaptiveDomain]);

impl MeshMotion for DomainMotion<'_> {
    fn place(&self, node: usize) -> Option<[f64; 2]> {
        self.0.iter().find_map(|domain| domain.new_place(node))
    }

    fn is_free(&self, node: usize) -> [bool; 2] {
        let domain = self.0.iter().find(|domain| domain.new_place(node).is_some());
        domain.map_or([false; 2], |domain| domain.is_free(node))
    }

    fn shift(&mut self, node: usize, by: [f64; 2]) {
        self.0.iter_mut().for_each(|domain| domain.shift(node, by));
    }
}

/// Replaces the domains in force. A domain of the same set keeps its history. Returns the numbers of changes of the domains
/// that have ended.
pub(super) fn change_domains(state: &mut State, domains: &[AdaptiveDomain]) -> Vec<MeshChanges> {
    let previous_domains = std::mem::replace(&mut state.adaptive, domains.to_vec());
    for domain in &mut state.adaptive {
        if let Some(previous) = previous_domains.iter().find(|previous| previous.id == domain.id) {
            domain.continue_from(previous);
        }
    }
    let has_ended = |previous: &&AdaptiveDomain| domains.iter().all(|domain| domain.id != previous.id);
    previous_domains.iter().filter(has_ended).map(changes_of).collect()
}

/// Passes the prescribed motions of the step to the domains.
pub(super) fn begin_domains(run: &mut RunState<'_>) {
    if run.state.adaptive.is_empty() {
        return;
    }
    let prescribed: Vec<_> = prescribed_motions(&run.state.constraints).collect();
    let State { adaptive, elements, thermal, dofs, constraints, .. } = &mut run.state;
    adaptive.iter_mut().for_each(|domain| domain.begin(&prescribed, &dofs.nodes));
    if let Some(heat) = thermal.as_mut().and_then(|thermal| thermal.heat.as_mut()) {
        adaptive.iter().for_each(|domain| heat.begin_adaptive(domain.group(), elements));
    }
    of_kind_mut(constraints).for_each(ContactConstraint::reserve_mesh_motion);
}

/// Takes the masses of adaptive meshes after a restart.
pub(super) fn restore_masses(state: &mut State) {
    if let Some(heat) = state.thermal.as_mut().and_then(|thermal| thermal.heat.as_mut()) {
        heat.restore_masses(&state.elements);
    }
}

/// Returns the smallest angle of the elements of all domains, degrees; NaN without a domain.
pub(super) fn smallest_angle(state: &State) -> f64 {
    let angles = state.adaptive.iter().map(|domain| domain.smallest_angle(&state.dofs.nodes));
    angles.fold(f64::NAN, f64::min).to_degrees()
}

/// Changes the meshes that are due, before an increment of length `dt`.
pub(super) fn adapt_meshes(state: &mut State, now: Instant, dt: f64, timing: &mut EffectTiming<'_>) {
    let mut is_any_due = false;
    for domain in &mut state.adaptive {
        is_any_due |= domain.is_due(now.increment);
    }
    if is_any_due {
        follow_by_contact(state, timing, |contact, dofs, _| contact.system.begin_mesh_motion(dofs));
        find_new_places(state, timing);
        follow_by_contact(state, timing, |contact, dofs, domains| contact.follow_meshes(dofs, domains));
        change_meshes(state, dt, timing);
    }
    let clock = AmplitudeClock { now, user_amplitudes: &state.user_amplitudes };
    state.adaptive.iter_mut().for_each(|domain| domain.advance(&clock, dt));
}

/// Calls contact before and after new places have been found.
fn follow_by_contact(
    state: &mut State,
    timing: &mut EffectTiming<'_>,
    mut follow: impl FnMut(&mut ContactConstraint, &Dofs, &mut DomainMotion<'_>),
) {
    let State { adaptive, dofs, constraints, .. } = state;
    for contact in of_kind_mut::<ContactConstraint>(constraints) {
        let effect = contact.effect();
        let clock = timing.start(effect);
        follow(contact, dofs, &mut DomainMotion(adaptive));
        timing.stop(clock, effect);
    }
}

fn find_new_places(state: &mut State, timing: &mut EffectTiming<'_>) {
    let State { adaptive, elements, dofs, constraints, .. } = state;
    let loops = ChunkLoops::new(elements.arch());
    for domain in adaptive {
        let clock = timing.start(domain.id);
        domain.find_new_places(loops, elements, &dofs.nodes, &ContactSurroundings { constraints, dofs });
        timing.stop(clock, domain.id);
    }
}

fn change_meshes(state: &mut State, dt: f64, timing: &mut EffectTiming<'_>) {
    let State { adaptive, elements, dofs, constraints, loads, thermal, .. } = state;
    let half = 0.5 * (dt + dofs.nodes.previous_dt);
    let loops = ChunkLoops::new(elements.arch());
    let mut has_changed = false;
    for domain in adaptive {
        let clock = timing.start(domain.id);
        if domain.begin_change() {
            let changed = &mut |n, gained: [f64; 2]| {
                constraints.iter_mut().for_each(|c| c.masses_changed(n, gained));
            };
            let mut thermal = thermal.as_deref_mut();
            take_thermal_strains(-1.0, domain, thermal.as_deref_mut(), elements);
            let heat = thermal.as_deref_mut().and_then(|thermal| thermal.heat.as_mut());
            domain.change((half, loops), elements, (dofs, heat), changed);
            take_thermal_strains(1.0, domain, thermal, elements);
            has_changed = true;
        }
        timing.stop(clock, domain.id);
    }
    if has_changed {
        let masses = SceneChange::Masses(dofs);
        loads.iter_mut().for_each(|load| load.scene_changed(&masses));
    }
}
