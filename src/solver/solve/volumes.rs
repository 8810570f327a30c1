//! Warning of elements whose mass does not belong to their volume, after changes of a mesh that does not follow the
//! material.

use super::outcome::Outcome;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::middle;
use crate::plan::{Plan, State};

/// Share of the mass of a section that may be missing in its elements, or too much, without a warning.
const NOTABLE: f64 = 0.01;

/// Differences between the masses of the elements of a group and those that fill their volumes at the density of the
/// material.
#[derive(Clone, Copy, Debug, Default)]
struct MassMismatch {
    /// Mass of the group.
    total: f64,
    /// Sum of the absolute differences.
    apart: f64,
    /// Largest absolute difference, its element, and the density of this element over that of its material.
    largest: f64,
    element: usize,
    ratio: f64,
}

/// Warns at the end of a run of masses that do not belong to the volumes of their elements.
pub(super) fn warn_of_volumes(plan: &Plan, state: &mut State, outcome: &mut Outcome) {
    for group in 0..state.elements.groups.len() {
        let MassMismatch { total, apart, element, ratio, .. } = mass_mismatch(state, group);
        if apart <= NOTABLE * total {
            continue;
        }
        let nodes = state.elements.groups[group].nodes(element);
        let corner = |i: usize| state.dofs.nodes[nodes[i] as usize].place();
        let [r, z] = middle([0, 1, 2, 3].inline_map(corner));
        let warning = format!(
            "changes of the mesh have changed the outline of the body of material {}: elements have {:.1} % more or less mass \
             than fills their volumes at the density of the material, most in element {} near (r = {r:.4e}, z = {z:.4e}), \
             which has {ratio:.3} times this density. Pressures use the density of the material and are not affected; \
             inertia is. Smaller elements where the outline is bent reduce the difference",
            plan.material_name(group, element),
            100.0 * apart / total,
            plan.element_name(group, element),
        );
        outcome.warn("R318", warning);
    }
}

fn mass_mismatch(state: &mut State, group: usize) -> MassMismatch {
    let (mut sums, group) = (MassMismatch::default(), &mut state.elements.groups[group]);
    for element in 0..group.len() {
        let Some(ratio) = group.transfer().and_then(|from| from.volume_ratio(element as u32)) else {
            return MassMismatch::default();
        };
        if group.is_deleted(element) {
            continue;
        }
        let mass: f64 = group.masses(element).into_iter().sum();
        let apart = (mass / ratio - mass).abs();
        (sums.total, sums.apart) = (sums.total + mass, sums.apart + apart);
        if apart > sums.largest {
            (sums.largest, sums.element, sums.ratio) = (apart, element, ratio);
        }
    }
    sums
}
