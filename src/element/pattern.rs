//! How far elements are folded into the pattern that one integration point does not see.
//! Never here: what resists it.

use super::group::ElementGroup;
use crate::kernel::quad::{Operators, dot3, section, sums};
use crate::state::nodes::Nodes;

/// The element that is folded most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Folded {
    /// Its group.
    pub group: usize,
    /// Its number there.
    pub element: usize,
    /// Displacement of a corner in the pattern over the root of the element's section.
    pub fold: f64,
}

/// The quadrilateral that its displacements have folded most; `None` without any. The pattern is that of Flanagan and
/// Belytschko 1981, Int. J. Numer. Meth. Eng. 17, 679, eq. 22, where the element is now: free of linear fields, so of
/// rotations and strains of any size.
pub fn strongest(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> Option<Folded> {
    let of_group = |(group, elements): (usize, &dyn ElementGroup)| {
        let alive = (0..elements.len()).filter(|&e| !elements.is_deleted(e));
        let folds = alive.map(|e| (e, fold(elements.corners(e).map(|n| n as usize), nodes)));
        let most = folds.filter(|(_, fold)| fold.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        most.map(|(element, fold)| Folded { group, element, fold })
    };
    groups.iter().map(|g| &**g).enumerate().filter_map(of_group).max_by(|a, b| a.fold.total_cmp(&b.fold))
}

fn fold(corners: [usize; 4], nodes: &Nodes) -> f64 {
    let places = corners.map(|n| nodes[n].place());
    let moved = |axis: usize| [0, 1, 2, 3].map(|i| places[i][axis] - nodes.start[corners[i]][axis]);
    let (r, z) = (places.map(|p| p[0]), places.map(|p| p[1]));
    let (all_r, all_z) = (sums(r), sums(z));
    let g = Operators::of::<true>(all_r, all_z);
    let shape = g.pattern([all_r[3], all_z[3]]).map(|part| part / g.volume);
    let pattern = |u: [f64; 4]| {
        let [_, first, second, pattern] = sums(u);
        0.25 * dot3(shape, [first, second, pattern])
    };
    pattern(moved(0)).hypot(pattern(moved(1))) / section(r, z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::fold;
    use crate::state::nodes::{Node, Nodes};

    fn moved(to: [[f64; 2]; 4]) -> f64 {
        let square = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        let node = |[r, z]: [f64; 2]| Node { r, z, v_r: 0.0, v_z: 0.0 };
        let mut nodes = Nodes::new(square.map(node).to_vec(), vec![1.0; 4]);
        (0..4).for_each(|i| nodes[i] = node(to[i]));
        fold([0, 1, 2, 3], &nodes)
    }

    #[test]
    fn linear_motion_folds_nothing_and_the_pattern_by_itself() {
        // Turned by a right angle, stretched and sheared.
        assert!(moved([[5.0, 1.0], [5.5, 3.0], [3.5, 3.5], [3.0, 1.5]]) < 1e-15);
        assert!((moved([[1.1, 0.0], [1.9, 0.0], [2.1, 1.0], [0.9, 1.0]]) - 0.1).abs() < 1e-2);
    }
}
