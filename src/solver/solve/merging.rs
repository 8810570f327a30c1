//! Merging of the mass of nodes whose elements are all deleted with their bodies (`NODAL EROSION=MERGE`).

use super::run_state::RunState;
use crate::constraint::equation::EquationConstraint;
use crate::constraint::{of_kind, prescribed_motions};
use crate::load::SceneChange;
use crate::plan::State;
use crate::state::nodes::Nodes;

/// Merges the nodes that have become free in this increment, after the accelerations and the kinetic energy have been
/// computed. The loss of kinetic energy is part of the energy lost in contact. Nodes with prescribed motions or equations
/// neither give nor receive mass, except that nodes on the axis may.
pub(super) fn merge_free_nodes(run: &mut RunState<'_>) {
    let State { elements, dofs, constraints, loads, .. } = &mut run.state;
    if !elements.deletions.has_fresh_nodes() {
        return;
    }
    let mut prescribed: Vec<(usize, usize)> = prescribed_motions(constraints).collect();
    prescribed.sort_unstable();
    let free_axes = |nodes: &Nodes, node: usize| {
        let is_on_axis = nodes[node].r == 0.0;
        let is_prescribed = |axis: usize| prescribed.binary_search(&(node, axis)).is_ok();
        let is_held = is_prescribed(1) || is_prescribed(0) && !is_on_axis;
        let is_linked = || of_kind::<EquationConstraint>(constraints).any(|equations| equations.has_node(node));
        (!is_held && !is_linked()).then_some([!is_on_axis, true])
    };
    if let Some(loss) = elements.deletions.merge_free_nodes(&mut dofs.nodes, free_axes) {
        dofs.energies.kinetic -= loss;
        dofs.energies.contact += loss;
        dofs.energies.impacts.merged_points += loss;
        loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::Masses(dofs)));
    }
}
