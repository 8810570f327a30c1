//! Facets of a nose in order along z, with the sums over all facets up to each one. The force on the facets inside a layer
//! is then a difference of two sums, and at most two facets per layer are cut by its planes.

use super::plug::plus;
use super::stack::{LayerStack, is_level};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;

/// Sums over the facets of one orientation inside one material. With the body velocity V, the normal velocity is v_n =
/// V |n_z|, so the force is a polynomial in V (reference: F = pi a^2 (A Y N0 + ...)).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FacetSums {
    /// Σ A |n_z|^(k+1), k = 0, 1, 2.
    normal: [f64; 3],
    /// Σ A |t_z| |n_z|^k.
    tangential: [f64; 3],
}

impl FacetSums {
    pub(super) fn of(facets: &[Facet]) -> Self {
        let mut sums = FacetSums::default();
        for facet in facets {
            sums.add(facet, facet.area);
        }
        sums
    }

    #[inline]
    pub(super) fn add(&mut self, facet: &Facet, area: f64) {
        let n = facet.normal[1].abs();
        let t = facet.normal[0].abs();
        let powers = [1.0, n, n * n];
        for (k, power) in powers.iter().enumerate() {
            self.normal[k] += area * n * power;
            self.tangential[k] += area * t * power;
        }
    }

    /// Returns the sums without those of other facets.
    #[inline]
    fn less(&self, other: &FacetSums) -> FacetSums {
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        FacetSums { normal: minus(self.normal, other.normal), tangential: minus(self.tangential, other.tangential) }
    }

    /// Returns the factors of V⁰, V¹ and V² of the axial force with a friction coefficient. Equation (2.3).
    pub(super) fn factors(&self, law: &CavityResistance, friction: f64) -> [f64; 3] {
        let constants = [law.c0, law.c1, law.c2];
        [0, 1, 2].inline_map(|k| constants[k] * (self.normal[k] + friction * self.tangential[k]))
    }

    /// Returns the magnitudes of the axial normal force and the axial tangential force (for a friction coefficient of
    /// 1) at speed V. Equation (2.3).
    #[inline]
    pub(super) fn forces(&self, law: &CavityResistance, speed: f64) -> [f64; 2] {
        let sum = |s: &[f64; 3]| law.c0 * s[0] + speed * (law.c1 * s[1] + speed * (law.c2 * s[2]));
        [sum(&self.normal), sum(&self.tangential)]
    }
}

/// Facets in ascending order along z that do not overlap along z, and facets normal to the axis.
#[derive(Clone, Debug, Memory)]
pub(super) struct NoseProfile {
    level: Vec<Facet>,
    facets: Vec<Facet>,
    /// Sums over the facets before each one, and over all.
    sums: Vec<FacetSums>,
}

impl NoseProfile {
    /// Returns the profile of facets; `None` if two overlap along z.
    pub(super) fn of(all: &[Facet]) -> Option<NoseProfile> {
        let level: Vec<Facet> = all.iter().filter(|f| is_level(f.normal)).copied().collect();
        let mut facets: Vec<Facet> = Vec::with_capacity(all.len());
        facets.extend(all.iter().filter(|f| !is_level(f.normal)));
        facets.sort_by(|a, b| a.low[1].total_cmp(&b.low[1]));
        if !facets.is_sorted_by(|a, b| a.high[1] <= b.low[1]) {
            return None;
        }
        let mut sums = Vec::with_capacity(facets.len() + 1);
        sums.push(FacetSums::default());
        for facet in &facets {
            let mut next = sums[sums.len() - 1];
            next.add(facet, facet.area);
            sums.push(next);
        }
        Some(NoseProfile { level, facets, sums })
    }

    /// Returns the magnitudes of the axial normal and tangential forces at speed V in laterally unbounded layers. Facets
    /// normal to the axis are in the layer that contains them after the displacement `level_shift`.
    pub(super) fn forces(&self, stack: &LayerStack, [shift, level_shift]: [f64; 2], speed: f64) -> [f64; 2] {
        let mut total = [0.0; 2];
        for facet in &self.level {
            let z = facet.low[1] + level_shift;
            if let Some(layer) = stack.layer_around(z, z) {
                total = plus(total, force_on(facet, &stack.laws[layer], facet.area, speed));
            }
        }
        let (Some(first), Some(last)) = (self.facets.first(), self.facets.last()) else { return total };
        for (planes, law) in stack.planes.windows(2).zip(&stack.laws) {
            let (from, end) = (planes[0] - shift, planes[1] - shift);
            if first.low[1] < end && from < last.high[1] {
                total = plus(total, self.forces_in_layer(from, end, law, speed));
            }
        }
        total
    }

    /// Returns the forces on the parts between two planes, given in the initial position of the nose.
    fn forces_in_layer(&self, from: f64, to: f64, law: &CavityResistance, speed: f64) -> [f64; 2] {
        let mut total = [0.0; 2];
        let mut cut = |facet: &Facet| total = plus(total, force_on(facet, law, facet.area_between(from, to), speed));
        let whole = self.whole_between(from, to, &mut cut);
        whole.map_or(total, |sums| plus(total, sums.forces(law, speed)))
    }

    /// Returns the facets normal to the axis.
    pub(super) fn level(&self) -> &[Facet] {
        &self.level
    }

    /// Returns the sums of the facets between two planes, given in the initial position of the nose, without facets normal
    /// to the axis; facets that a plane cuts are passed to `cut`. `None` if no whole facet is between the planes.
    pub(super) fn whole_between(&self, from: f64, to: f64, cut: &mut impl FnMut(&Facet)) -> Option<FacetSums> {
        let facets = &self.facets[..];
        let starts_inside = facets.first().is_some_and(|f| from <= f.low[1]);
        let ends_inside = facets.last().is_some_and(|f| f.high[1] <= to);
        let mut start = if starts_inside { 0 } else { facets.partition_point(|f| f.high[1] <= from) };
        let mut end = if ends_inside { facets.len() } else { facets.partition_point(|f| f.low[1] < to) };
        if start < end && self.facets[start].low[1] < from {
            cut(&self.facets[start]);
            start += 1;
        }
        if start < end && self.facets[end - 1].high[1] > to {
            end -= 1;
            cut(&self.facets[end]);
        }
        (start < end).then(|| self.sums[end].less(&self.sums[start]))
    }
}

/// Returns the axial normal and tangential force on an area of a facet at speed V.
#[inline]
pub(super) fn force_on(facet: &Facet, law: &CavityResistance, area: f64, speed: f64) -> [f64; 2] {
    let n = facet.normal[1].abs();
    let force = area * law.stress(speed * n);
    [force * n, force * facet.normal[0].abs()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the forces as sums over all facets and layers.
    fn sum_over_parts(facets: &[Facet], stack: &LayerStack, shift: f64, speed: f64) -> [f64; 2] {
        let mut total = [0.0; 2];
        for facet in facets {
            for (planes, law) in stack.planes.windows(2).zip(&stack.laws) {
                let (from, end) = (planes[0] - shift, planes[1] - shift);
                let area = if !is_level(facet.normal) {
                    facet.area_between(from, end)
                } else if from < facet.low[1] && facet.low[1] < end {
                    facet.area
                } else {
                    0.0
                };
                total = plus(total, force_on(facet, law, area, speed));
            }
        }
        total
    }

    #[test]
    fn running_sums_give_the_force_of_all_parts() {
        let law = |c0: f64| CavityResistance { c0, c1: 0.3 * c0, c2: 0.01 * c0 };
        // Layers that follow each other along -z; the second is thinner than a facet.
        let stack = LayerStack::new(0.0, -1.0, &[(0.4, law(1.0)), (0.03, law(7.0)), (0.6, law(2.0))]);
        // A flat tip, a curved flank, and facets out of order.
        let flank = |i: u32| [0.2 + (f64::from(i) / 10.0).sqrt(), f64::from(i) / 10.0];
        let mut facets: Vec<Facet> = (0..10).filter_map(|i| Facet::new(flank(i), flank(i + 1), false)).collect();
        facets.push(Facet::new([0.0, 0.0], [0.2, 0.0], false).expect("a disc"));
        facets.reverse();
        let profile = NoseProfile::of(&facets).expect("facets in one order along z");
        let mut cut = 0;
        for step in 0..400 {
            let shift = 0.1 - 0.0077 * f64::from(step);
            let expected = sum_over_parts(&facets, &stack, shift, 3.0);
            let forces = profile.forces(&stack, [shift; 2], 3.0);
            let scale = 100.0 * facets.iter().map(|f| f.area).sum::<f64>();
            for (a, b) in forces.iter().zip(expected) {
                assert!((a - b).abs() < 1e-15 * scale, "shift {shift}: {a:e} and {b:e}");
            }
            cut += usize::from(expected[0] > 0.0);
        }
        assert!(cut > 200, "the nose is in the target in {cut} positions");
    }

    #[test]
    fn facets_that_overlap_along_z_have_no_profile() {
        let facet = |low: f64| Facet::new([0.1, low], [0.2, low + 1.0], false).expect("a cone");
        assert!(NoseProfile::of(&[facet(0.0), facet(0.5)]).is_none());
        assert!(NoseProfile::of(&[facet(1.0), facet(0.0)]).is_some());
    }
}
