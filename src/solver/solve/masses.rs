//! Mass scaling: its energy in the balance, the added mass of the model and of each section, and the warning of added mass.

use super::outcome::AddedMassPlaces;
use super::run_state::RunState;
use crate::constraint::of_kind;
use crate::constraint::tie::TiedNodes;
use crate::element::elements::Elements;
use crate::element::mass_scaling::AddedMass;
use crate::load::SceneChange;
use crate::plan::State;
use crate::state::archive::Persist;

/// Fraction of added mass, and ratio of the kinetic energy to that put in, above which a warning is issued. Where bodies
/// hardly move, added mass changes little.
const NOTABLE: [f64; 2] = [0.05, 0.1];
/// Largest number of sections that the warning names.
const NAMED: usize = 4;

/// Masses without scaling, and the largest kinetic energy with added mass.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct MassMonitor {
    /// Original mass of each element group; empty before the first scaling.
    original: Vec<f64>,
    /// Original mass of each rigid body; empty before the first scaling.
    bodies: Vec<f64>,
    /// Mass that scaling has added to the rigid bodies.
    added_to_bodies: f64,
    /// Ratio of added to original mass of each element group, since the last scaling.
    added_shares: Vec<f64>,
    /// Largest kinetic energy of the deformable bodies while added mass was above the limit of the warning.
    kinetic: f64,
}

impl MassMonitor {
    /// Returns the mass that scaling has added; `None` without mass scaling.
    fn added_mass_places(&self, elements: &Elements) -> Option<AddedMassPlaces> {
        let AddedMass { added, linked, .. } = elements.mass_scaling.added_mass()?;
        let rigid_bodies = self.added_to_bodies;
        Some(AddedMassPlaces { free_nodes: added - linked, linked_nodes: linked, rigid_bodies })
    }

    /// Returns the added mass in percent of the original mass of the deformable bodies; `None` without mass scaling.
    pub(super) fn added_percent(&self, elements: &Elements) -> Option<f64> {
        let original = elements.mass_scaling.added_mass()?.original;
        Some(100.0 * self.added_mass_places(elements)?.total() / original)
    }

    /// Records the kinetic energy of the deformable bodies if much mass has been added.
    pub(super) fn record_kinetic(&mut self, kinetic: f64, state: &State) {
        if state.scaling.is_some() && kinetic > self.kinetic {
            let total = self.added_percent(&state.elements).unwrap_or(0.0);
            if total > 100.0 * NOTABLE[0] || self.added_shares.iter().any(|added| *added > NOTABLE[0]) {
                self.kinetic = kinetic;
            }
        }
    }
}

/// Scales masses if due. The kinetic energy of added mass is not work of a load, and has an energy account. Returns the
/// places of all added mass if masses have changed.
pub(super) fn scale_masses(run: &mut RunState<'_>) -> Option<AddedMassPlaces> {
    let scaling = run.state.scaling.as_mut()?;
    if run.masses.original.is_empty() {
        run.masses.original = group_masses(&run.state.elements).collect();
        run.masses.bodies = run.state.dofs.bodies.iter().map(|body| body.mass).collect();
    }
    let (constraints, mut energy) = (&mut run.state.constraints, 0.0);
    let changed = &mut |n, gained: [f64; 2]| {
        energy += gained[0] + gained[1];
        constraints.iter_mut().for_each(|c| c.masses_changed(n, gained));
    };
    if !run.state.elements.scale_masses(scaling, &run.now, &mut run.state.dofs, changed) {
        return None;
    }
    energy += scale_bodies(run);
    run.balance.add_mass_work(energy);
    let masses = SceneChange::Masses(&run.state.dofs);
    run.state.loads.iter_mut().for_each(|load| load.scene_changed(&masses));
    let ratio = |(scaled, original): (f64, &f64)| if *original > 0.0 { scaled / original - 1.0 } else { 0.0 };
    let MassMonitor { original, added_shares, .. } = &mut run.masses;
    added_shares.clear();
    added_shares.extend(group_masses(&run.state.elements).zip(&*original).map(ratio));
    run.masses.record_kinetic(run.balance.kinetic_of_solid(), &run.state);
    run.masses.added_mass_places(&run.state.elements)
}

/// Adds to each rigid body the mass that scaling adds at its nodes. Returns the kinetic energy of this mass; at a
/// prescribed body it is work of the prescribed motion, and zero here.
fn scale_bodies(run: &mut RunState<'_>) -> f64 {
    let State { constraints, elements, dofs, .. } = &mut run.state;
    let (mut energy, starts) = (0.0, run.previous_dt == 0.0);
    run.masses.added_to_bodies = 0.0;
    for tie in of_kind::<TiedNodes>(constraints) {
        let added = elements.mass_scaling.added_to_body(&tie.nodes);
        let mass = run.masses.bodies[tie.body] + added;
        run.masses.added_to_bodies += added;
        let body = &mut dofs.bodies[tie.body];
        if mass != body.mass {
            let gained = body.change_mass(mass, starts);
            energy += if body.prescribed { 0.0 } else { gained };
        }
    }
    dofs.energies.external += energy;
    energy
}

/// Returns the warning at the end of a run if much mass has been added to bodies that moved.
pub(super) fn warning_of_added_mass(run: &RunState<'_>) -> Option<String> {
    let mut masses = run.masses.clone();
    masses.record_kinetic(run.balance.kinetic_of_solid(), &run.state);
    let heat = run.energy().heat.map_or(0.0, f64::abs);
    let moving = masses.kinetic / run.balance.put_in().max(heat);
    let total = masses.added_percent(&run.state.elements).filter(|_| moving > NOTABLE[1])?;
    let shares = masses.added_shares.iter().copied().enumerate();
    let mut sections: Vec<(usize, f64)> = shares.filter(|section| section.1 > NOTABLE[0]).collect();
    sections.sort_by(|a, b| b.1.total_cmp(&a.1));
    let name = |(group, added): &(usize, f64)| {
        let (element, material) = (run.plan.element_name(*group, 0), run.plan.material_name(*group, 0));
        format!("{:.1} % to the section of element {element} (material {material})", 100.0 * added)
    };
    let named: Vec<String> = sections.iter().take(NAMED).map(name).collect();
    Some(format!(
        "mass scaling has added {total:.1} % to the mass of the deformable bodies{}: {}; their kinetic energy was up to {:.1} \
         % of the energy put in. Added mass changes inertia and impact forces; compare with a smaller target increment. \
         The histories DMASS, ALLMW (energy of the added mass) and PARTMASS (mass of a set) show its growth",
        masses.added_mass_places(&run.state.elements).unwrap_or_default().describe(),
        named.join(", "),
        100.0 * moving
    ))
}

/// Returns the mass of each element group.
fn group_masses(elements: &Elements) -> impl Iterator<Item = f64> {
    elements.groups.iter().map(|group| (0..group.len()).map(|e| group.masses(e).into_iter().sum::<f64>()).sum())
}
