//! Warning of elements whose mass does not belong to their volume, after changes of a mesh that does not follow the
//! material.

use super::run::SolverRun;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::middle;

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
    worst: (f64, usize, f64),
}

impl SolverRun<'_> {
    /// Warns at the end of a run of masses that do not belong to the volumes of their elements.
    pub(super) fn warn_of_volumes(&mut self) {
        for group in 0..self.state.elements.groups.len() {
            let MassMismatch { total, apart, worst: (_, element, ratio) } = self.mass_mismatch(group);
            if apart <= NOTABLE * total {
                continue;
            }
            let nodes = self.state.elements.groups[group].nodes(element);
            let place = |i: usize| self.state.dofs.nodes[nodes[i] as usize].place();
            let [r, z] = middle([0, 1, 2, 3].inline_map(place));
            let warning = format!(
                "changes of the mesh have changed the outline of the body of material {}: elements have {:.1} % more or less mass \
                 than fills their volumes at the density of the material, most in element {} near (r = {r:.4e}, z = {z:.4e}), \
                 which has {ratio:.3} times this density. Pressures use the density of the material and are not affected; \
                 inertia is. Smaller elements where the outline is bent reduce the difference",
                self.plan.material_name(group, element),
                100.0 * apart / total,
                self.plan.element_name(group, element),
            );
            self.outcome.warn("R318", warning);
        }
    }

    fn mass_mismatch(&mut self, group: usize) -> MassMismatch {
        let (mut sums, group) = (MassMismatch::default(), &mut self.state.elements.groups[group]);
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
            if apart > sums.worst.0 {
                sums.worst = (apart, element, ratio);
            }
        }
        sums
    }
}
