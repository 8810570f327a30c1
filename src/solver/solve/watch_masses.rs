//! Mass scaling: its energy in the balance, the added mass of the model and of each section, and the warning of added mass.

use super::masses::MassMonitor;
use super::outcome::AddedMassPlaces;
use super::run::SolverRun;
use crate::constraint::of_kind;
use crate::constraint::tie::TiedNodes;
use crate::element::elements::Elements;
use crate::element::mass_scaling::AddedMass;
use crate::load::SceneChange;
use crate::plan::State;

/// Fraction of added mass, and ratio of the kinetic energy to that put in, above which a warning is issued. Where bodies
/// hardly move, added mass changes little.
const NOTABLE: [f64; 2] = [0.05, 0.1];
/// Largest number of sections that the warning names.
const NAMED: usize = 4;

impl SolverRun<'_> {
    /// Scales masses if due. The kinetic energy of added mass is not work of a load, and has an energy account.
    pub(super) fn scale_masses(&mut self) {
        let Some(scaling) = &mut self.state.scaling else { return };
        if self.watch.masses.original.is_empty() {
            self.watch.masses.original = group_masses(&self.state.elements).collect();
            self.watch.masses.bodies = self.state.dofs.bodies.iter().map(|body| body.mass).collect();
        }
        let (constraints, mut energy) = (&mut self.state.constraints, 0.0);
        let changed = &mut |n, gained: [f64; 2]| {
            energy += gained[0] + gained[1];
            constraints.iter_mut().for_each(|c| c.masses_changed(n, gained));
        };
        if !self.state.elements.scale_masses(scaling, &self.now, &mut self.state.dofs, changed) {
            return;
        }
        energy += self.scale_bodies();
        self.balance.add_mass_work(energy);
        let masses = SceneChange::Masses(&self.state.dofs);
        self.state.loads.iter_mut().for_each(|load| load.scene_changed(&masses));
        let places = self.added_mass_places();
        if let Some(summary) = self.outcome.steps.last_mut() {
            (summary.added_mass, summary.added_mass_at) = (places.map(|places| places.total()), places);
        }
        let ratio = |(now, original): (f64, &f64)| if *original > 0.0 { now / original - 1.0 } else { 0.0 };
        let MassMonitor { original, added_shares, .. } = &mut self.watch.masses;
        added_shares.clear();
        added_shares.extend(group_masses(&self.state.elements).zip(&*original).map(ratio));
        self.watch_masses();
    }

    /// Adds to each rigid body the mass that scaling adds at its nodes. Returns the kinetic energy of this mass; at a
    /// prescribed body it is work of the prescribed motion, and zero here.
    fn scale_bodies(&mut self) -> f64 {
        let State { constraints, elements, dofs, .. } = &mut self.state;
        let (mut energy, starts) = (0.0, self.previous_dt == 0.0);
        self.watch.masses.added_to_bodies = 0.0;
        for tie in of_kind::<TiedNodes>(constraints) {
            let added = elements.mass_added_to_body(&tie.nodes);
            let mass = self.watch.masses.bodies[tie.body] + added;
            self.watch.masses.added_to_bodies += added;
            let body = &mut dofs.bodies[tie.body];
            if mass != body.mass {
                let gained = body.change_mass(mass, starts);
                energy += if body.prescribed { 0.0 } else { gained };
            }
        }
        dofs.energies.external += energy;
        energy
    }

    /// Returns the mass that scaling has added; `None` without mass scaling.
    fn added_mass_places(&self) -> Option<AddedMassPlaces> {
        let AddedMass { added, linked, .. } = self.state.elements.added_mass()?;
        let rigid_bodies = self.watch.masses.added_to_bodies;
        Some(AddedMassPlaces { free_nodes: added - linked, linked_nodes: linked, rigid_bodies })
    }

    /// Returns the added mass in percent of the original mass of the deformable bodies; `None` without mass scaling.
    pub(super) fn added_mass_percent(&self) -> Option<f64> {
        let original = self.state.elements.added_mass()?.original;
        Some(100.0 * self.added_mass_places()?.total() / original)
    }

    /// Records the kinetic energy if much mass has been added.
    pub(super) fn watch_masses(&mut self) {
        if self.state.scaling.is_some() && self.balance.kinetic_of_solid() > self.watch.masses.kinetic {
            let total = self.added_mass_percent().unwrap_or(0.0);
            if total > 100.0 * NOTABLE[0] || self.watch.masses.added_shares.iter().any(|added| *added > NOTABLE[0]) {
                self.watch.masses.kinetic = self.balance.kinetic_of_solid();
            }
        }
    }

    /// Warns at the end of a run if much mass has been added to bodies that moved.
    pub(super) fn warn_of_added_mass(&mut self) {
        self.watch_masses();
        let heat = self.energy().heat.map_or(0.0, f64::abs);
        let moving = self.watch.masses.kinetic / self.balance.put_in().max(heat);
        let total = self.added_mass_percent();
        let Some(total) = total.filter(|_| moving > NOTABLE[1]) else { return };
        let mut sections: Vec<(usize, f64)> = self
            .watch
            .masses
            .added_shares
            .iter()
            .copied()
            .enumerate()
            .filter(|section| section.1 > NOTABLE[0])
            .collect();
        sections.sort_by(|a, b| b.1.total_cmp(&a.1));
        let name = |(group, added): &(usize, f64)| {
            let (element, material) = (self.plan.element_name(*group, 0), self.plan.material_name(*group, 0));
            format!("{:.1} % to the section of element {element} (material {material})", 100.0 * added)
        };
        let named: Vec<String> = sections.iter().take(NAMED).map(name).collect();
        let warning = format!(
            "mass scaling has added {total:.1} % to the mass of the deformable bodies{}: {}; their kinetic energy was up to {:.1} \
             % of the energy put in. Added mass changes inertia and impact forces; compare with a smaller target increment. \
             The histories DMASS, ALLMW (energy of the added mass) and PARTMASS (mass of a set) show its growth",
            self.added_mass_places().unwrap_or_default().describe(),
            named.join(", "),
            100.0 * moving
        );
        self.outcome.warn("R316", warning);
    }
}

/// Returns the mass of each element group.
fn group_masses(elements: &Elements) -> impl Iterator<Item = f64> {
    elements.groups.iter().map(|group| (0..group.len()).map(|e| group.masses(e).into_iter().sum::<f64>()).sum())
}
