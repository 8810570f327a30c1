//! Adaptive meshes in the time loop: they change after the length of the next increment is known and before the nodes
//! move.

use super::run::SolverRun;
use crate::adaptive::AdaptiveDomain;
use crate::load::SceneChange;
use crate::plan::State;

impl SolverRun<'_> {
    /// Replaces the domains in force. A domain of the same card keeps its history.
    pub(super) fn change_domains(&mut self, domains: &[AdaptiveDomain]) {
        let before = std::mem::replace(&mut self.state.adaptive, domains.to_vec());
        for domain in &mut self.state.adaptive {
            if let Some(previous) = before.iter().find(|previous| previous.id == domain.id) {
                domain.continue_from(previous);
            }
        }
    }

    /// Passes the prescribed motions of the step to the domains.
    pub(super) fn begin_domains(&mut self) {
        if self.state.adaptive.is_empty() {
            return;
        }
        let forces = self.state.constraints.iter().filter_map(|c| c.view().forces);
        let prescribed: Vec<_> = forces.flat_map(|forces| forces.prescribed()).collect();
        self.state.adaptive.iter_mut().for_each(|domain| domain.begin(&prescribed));
    }

    /// Changes the meshes that are due, before an increment of length `dt`.
    pub(super) fn adapt_meshes(&mut self, dt: f64) {
        if self.state.adaptive.is_empty() {
            return;
        }
        let State { adaptive, elements, dofs, constraints, loads, .. } = &mut self.state;
        let half = 0.5 * (dt + dofs.nodes.previous_dt);
        let mut has_changed = false;
        for domain in adaptive {
            let clock = self.timing.start(domain.id);
            let changed = &mut |n, gained: [f64; 2]| {
                constraints.iter_mut().filter_map(|c| c.upkeep()).for_each(|c| c.masses_changed(n, gained));
            };
            has_changed |= domain.adapt(self.now.increment, half, elements, dofs, changed);
            self.timing.stop(clock, domain.id);
        }
        if has_changed {
            let masses = SceneChange::Masses(&dofs.nodes.mass);
            loads.iter_mut().for_each(|load| load.scene_changed(&masses));
        }
    }
}
