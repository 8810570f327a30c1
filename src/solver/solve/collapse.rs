//! Collapse of the time increment: a few elements, for example squashed ones, reduce the increment of the whole model and
//! multiply the run time. Records how many increments they have reduced, and gives the warnings.

use super::mesh_quality::is_squashed;
use super::run_state::RunState;
use crate::element::group::ElementGroup;
use crate::plan::{AutomaticMeshes, MeshCards, Plan};
use crate::state::archive::Persist;

/// Ratio of the largest stable time increment so far to the increment, from which the increment has collapsed.
const COLLAPSED: f64 = 25.0;
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

/// History of the stable time increment.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct CollapseMonitor {
    /// Largest stable time increment of the elements.
    largest: f64,
    /// Number of collapsed increments, total time of the first one, and the smallest one with its group and element.
    count: u64,
    since: f64,
    smallest: f64,
    place: (usize, usize),
    /// Whether the last check found a collapse, and the increment of the last report, 0 before.
    seen: bool,
    reported: f64,
}

impl CollapseMonitor {
    /// Counts an increment that the elements limit and that starts at the total time `time`.
    #[inline(always)]
    pub(super) fn count(&mut self, length: f64, time: f64, place: (usize, usize)) {
        if length * COLLAPSED < self.largest {
            if self.count == 0 {
                (self.since, self.smallest) = (time, f64::INFINITY);
            }
            self.count += 1;
            if length < self.smallest {
                (self.smallest, self.place) = (length, place);
            }
        }
    }

    pub(super) fn is_reported(&self) -> bool {
        self.reported > 0.0
    }

    /// Checks for a collapse. Returns a warning at the second successive check that finds one that at least doubles the
    /// number of increments.
    pub(super) fn check(&mut self, run: &RunState<'_>) -> Option<String> {
        let limiting = run.state.elements.limiting().filter(|_| !run.step.is_fixed())?;
        let (stable, remaining) = (run.state.elements.stable_increment(), run.step.duration - run.now.step_time);
        self.largest = self.largest.max(stable);
        let (increments_left, undisturbed) = (remaining / (stable * run.step.scale_factor), remaining / self.largest);
        let collapsed = stable * COLLAPSED < self.largest;
        let costly = increments_left > MANY && increments_left > run.now.increment as f64 + undisturbed;
        let again = self.is_reported() && stable * FURTHER > self.reported;
        let is_collapse = collapsed && costly && !again && !run.is_noise() && self.few_are_small(run);
        if std::mem::replace(&mut self.seen, is_collapse) && is_collapse {
            self.reported = stable;
            return Some(self.describe(run, limiting, [stable, increments_left]));
        }
        None
    }

    /// Returns whether few elements have a small stable time increment.
    fn few_are_small(&self, run: &RunState<'_>) -> bool {
        let (elements, nodes) = (&run.state.elements, run.state.dofs.nodes.as_slice());
        let limit = SMALL / self.largest;
        let small = |group: &dyn ElementGroup| {
            let is_small = |e: &usize| group.stable_rate(*e, None, nodes).is_some_and(|rate| rate > limit);
            (0..group.len()).filter(is_small).count()
        };
        let count: usize = elements.groups.iter().map(|group| small(&**group)).sum();
        count as f64 <= (FEW * elements.count() as f64).max(1.0)
    }

    fn describe(&self, run: &RunState<'_>, limiting: (usize, usize), [stable, increments_left]: [f64; 2]) -> String {
        let (largest, increments) = (self.largest, run.now.increment.max(1) as f64);
        format!(
            "the time increment collapses: at increment {}, time {:e} element {} has reduced it from {largest:.3e} to \
             {stable:.3e}, by a factor of {:.0}. {:.0} % of the increments so far are reduced by more than a factor of {COLLAPSED}; at this \
             pace {increments_left:.1e} increments remain in the step, {:.1} times as many as so far. {}",
            run.now.increment,
            run.now.total_time,
            name_element(run.plan, limiting),
            largest / stable,
            100.0 * self.count as f64 / increments,
            increments_left / increments,
            name_remedies(run, limiting.0, Some(largest / COLLAPSED))
        )
    }

    /// Returns a warning at the end of the run if a collapse has caused many of the increments.
    pub(super) fn final_warning(&self, run: &RunState<'_>) -> Option<String> {
        let CollapseMonitor { largest, count, since, smallest, place, .. } = *self;
        let share = count as f64 / run.now.increment.max(1) as f64;
        if !self.is_reported() || share < SHARE {
            return None;
        }
        Some(format!(
            "{:.0} % of the increments ({count} of {}) are reduced by more than a factor of {COLLAPSED}, since time {since:e}: \
             the smallest, {smallest:.3e} in place of {largest:.3e}, is that of element {}. {}",
            100.0 * share,
            run.now.increment,
            name_element(run.plan, place),
            name_remedies(run, place.0, Some(largest / COLLAPSED))
        ))
    }
}

/// Returns the cards that keep an element of a group from reducing the increment below `least`, without those of the deck.
pub(super) fn name_remedies(run: &RunState<'_>, group: usize, least: Option<f64>) -> String {
    let MeshCards { erodes, controls_distortion, scales_masses } = run.plan.mesh_cards;
    let value = |name: &str| least.map_or_else(String::new, |least| format!(", {name}={least:.1e}"));
    let renewal = name_renewal(run, group);
    // In a body that can have new meshes, no other card keeps the shape of an element that plastic flow has squashed.
    let mut supported = run.plan.automatic_meshes.iter().flat_map(AutomaticMeshes::groups);
    let is_supported = supported.any(|supported| supported == group);
    if let Some(renewal) = renewal.as_ref().filter(|_| is_supported && is_squashed(&run.state.elements)) {
        return format!("plastic flow has squashed it: {renewal}");
    }
    // Distortion control is refused on meshes that do not follow the material.
    let follows_material = run.plan.remesh.is_none() && run.state.adaptive.is_empty();
    let mut remeshed = run.plan.remesh.iter().flat_map(|remesh| &remesh.bodies).filter(|body| body.group == group);
    if let Some(body) = remeshed.next().filter(|_| is_squashed(&run.state.elements)) {
        let remedy = if body.automatic {
            "*REMESH in the deck leaves out sheets and webs that are thinner than a part of its elements"
        } else {
            "a larger THICKNESS of *REMESH leaves out thicker sheets and webs"
        };
        return format!("plastic flow has squashed it, and a newer mesh is not better or not valid (R317): {remedy}");
    }
    let cards = [
        renewal,
        (!erodes).then(|| format!("*EROSION{} deletes such elements", value("INCREMENT"))),
        (!controls_distortion && follows_material)
            .then(|| "DISTORTION CONTROL=YES on *SECTION CONTROLS keeps them from being squashed".to_owned()),
        (!scales_masses)
            .then(|| format!("*VARIABLE MASS SCALING, TYPE=BELOW MIN{} adds mass to them alone", value("DT"))),
    ];
    let cards: Vec<String> = cards.into_iter().flatten().collect();
    if cards.is_empty() { "A coarser mesh there has larger increments".into() } else { cards.join(", ") }
}

/// Returns the cards that renew the mesh of a body and that the deck does not have, or why `*REMESH` cannot; `None` in a deck with
/// `*REMESH`.
fn name_renewal(run: &RunState<'_>, group: usize) -> Option<String> {
    let renewal = run.plan.renewals.get(group).filter(|_| run.plan.remesh.is_none())?;
    let adapts = !run.state.adaptive.is_empty();
    Some(match &renewal.refusal {
        None if adapts => "*REMESH in place of *ADAPTIVE MESH gives a body that deforms far a new mesh".into(),
        None if renewal.adapts => {
            "*REMESH or *ADAPTIVE MESH keeps the elements of a body that deforms far in shape".into()
        }
        None => "*REMESH keeps the elements of a body that deforms far in shape".into(),
        Some(_) if renewal.adapts && !adapts => {
            "*ADAPTIVE MESH keeps the elements of a body that deforms far in shape".into()
        }
        Some(refusal) => format!("a new mesh would help, but the body cannot have one: {refusal}"),
    })
}

/// Returns the end of a message of an element that has folded.
pub(super) fn name_folding_remedy(run: &RunState<'_>, group: usize) -> String {
    name_renewal(run, group).map_or_else(String::new, |renewal| format!(". {renewal}"))
}

fn name_element(plan: &Plan, (group, element): (usize, usize)) -> String {
    let material = plan.material_name(group, element);
    let material_text = if material.is_empty() { String::new() } else { format!(" (material {material})") };
    format!("{}{material_text}", plan.element_name(group, element))
}
