//! Warnings of a collapsing time increment: a few elements, for example squashed ones, reduce the increment of the whole
//! model and multiply the run time.

use super::collapse::{COLLAPSED, CollapseMonitor};
use super::run::SolverRun;
use crate::plan::{MeshCards, Plan};

/// Ratio of increments from which an element counts among the causes of the collapse.
const SMALL: f64 = 0.5 * COLLAPSED;
/// Largest fraction of the elements that may cause a collapse. More elements mean that the model deforms as a whole.
const FEW: f64 = 0.05;
/// Number of remaining increments below which a collapse costs too little for a warning.
const MANY: f64 = 2000.0;
/// Ratio of increments after which a further collapse is reported again.
const FURTHER: f64 = 10.0;
/// Fraction of the increments of an analysis above which a warning at its end gives the cost of the collapse.
const SHARE: f64 = 0.2;

impl SolverRun<'_> {
    /// Checks for a collapse; warns at the second successive check that finds one that at least doubles the number of
    /// increments.
    pub(super) fn watch_collapse(&mut self) {
        if self.state.elements.is_empty() || self.step.is_fixed() {
            return;
        }
        let (stable, remaining) = (self.state.elements.stable_increment(), self.step.duration - self.now.step_time);
        let CollapseMonitor { largest, reported, .. } = &mut self.watch.collapse;
        *largest = largest.max(stable);
        let (left, undisturbed) = (remaining / (stable * self.step.scale_factor), remaining / *largest);
        let collapsed = stable * COLLAPSED < *largest;
        let costly = left > MANY && left > self.now.increment as f64 + undisturbed;
        let again = *reported > 0.0 && stable * FURTHER > *reported;
        let found = collapsed && costly && !again && !self.is_noise() && self.few_are_small();
        if std::mem::replace(&mut self.watch.collapse.seen, found) && found {
            self.watch.collapse.reported = stable;
            let warning = self.name_collapse(stable, left);
            self.outcome.warn("R307", warning);
        }
    }

    /// Returns whether few elements have a small stable time increment.
    fn few_are_small(&self) -> bool {
        let (elements, nodes) = (&self.state.elements, self.state.dofs.nodes.as_slice());
        let rate = SMALL / self.watch.collapse.largest;
        let small = |group: &dyn crate::element::group::ElementGroup| {
            let own = |e: &usize| group.stable_rate(*e, None, nodes).is_some_and(|own| own > rate);
            (0..group.len()).filter(own).count()
        };
        let count: usize = elements.groups.iter().map(|group| small(&**group)).sum();
        count as f64 <= (FEW * elements.count() as f64).max(1.0)
    }

    fn name_collapse(&self, stable: f64, left: f64) -> String {
        let largest = self.watch.collapse.largest;
        let done = self.now.increment.max(1) as f64;
        format!(
            "the time increment collapses: at increment {}, time {:e} element {} has reduced it from {largest:.3e} to \
             {stable:.3e}, by a factor of {:.0}. {:.0} % of the increments so far are reduced by more than a factor of {COLLAPSED}; at this \
             pace {left:.1e} increments remain in the step, {:.1} times as many as so far. {}",
            self.now.increment,
            self.now.total_time,
            name_element(self.plan, self.state.elements.limiting()),
            largest / stable,
            100.0 * self.watch.collapse.count as f64 / done,
            left / done,
            self.name_remedies(self.state.elements.limiting(), Some(largest / COLLAPSED))
        )
    }

    /// Warns at the end of the run if a collapse has caused many of the increments.
    pub(super) fn warn_of_collapse(&mut self) {
        let CollapseMonitor { largest, count, since, smallest, place, reported, .. } = self.watch.collapse;
        let share = count as f64 / self.now.increment.max(1) as f64;
        if reported == 0.0 || share < SHARE {
            return;
        }
        self.outcome.warn("R307", format!(
            "{:.0} % of the increments ({count} of {}) are reduced by more than a factor of {COLLAPSED}, since time {since:e}: \
             the smallest, {smallest:.3e} in place of {largest:.3e}, is that of element {}. {}",
            100.0 * share,
            self.now.increment,
            name_element(self.plan, place),
            self.name_remedies(place, Some(largest / COLLAPSED))
        ));
    }
}

impl SolverRun<'_> {
    /// Returns the cards that keep an element from reducing the increment below `least`, without those of the deck.
    pub(super) fn name_remedies(&self, (group, _): (usize, usize), least: Option<f64>) -> String {
        let MeshCards { erodes, controls_distortion, scales_masses } = self.plan.mesh_cards;
        let value = |name: &str| least.map_or_else(String::new, |least| format!(", {name}={least:.1e}"));
        let cards = [
            self.name_renewal(group).map(str::to_owned),
            (!erodes).then(|| format!("*EROSION{} deletes such elements", value("INCREMENT"))),
            (!controls_distortion)
                .then(|| "DISTORTION CONTROL=YES on *SECTION CONTROLS keeps them from being squashed".to_owned()),
            (!scales_masses)
                .then(|| format!("*VARIABLE MASS SCALING, TYPE=BELOW MIN{} adds mass to them alone", value("DT"))),
        ];
        let cards: Vec<String> = cards.into_iter().flatten().collect();
        if cards.is_empty() { "A coarser mesh there has larger increments".into() } else { cards.join(", ") }
    }
}

impl SolverRun<'_> {
    /// Returns the cards that renew the mesh of a body and that the deck does not have; `None` if there are none.
    fn name_renewal(&self, group: usize) -> Option<&'static str> {
        let (remeshes, adapts) = (self.plan.remesh.is_some(), !self.state.adaptive.is_empty());
        if remeshes || self.plan.movable_groups.get(group) != Some(&true) {
            None
        } else if adapts {
            Some("*REMESH in place of *ADAPTIVE MESH gives a body that deforms far a new mesh")
        } else {
            Some("*REMESH or *ADAPTIVE MESH keeps the elements of a body that deforms far in shape")
        }
    }

    /// Returns the end of a message of an element that has folded.
    pub(super) fn name_folding_remedy(&self, group: usize) -> String {
        self.name_renewal(group).map_or_else(String::new, |renewal| format!(". {renewal}"))
    }
}

fn name_element(plan: &Plan, (group, element): (usize, usize)) -> String {
    let material = plan.material_name(group, element);
    let of = if material.is_empty() { String::new() } else { format!(" (material {material})") };
    format!("{}{of}", plan.element_name(group, element))
}
