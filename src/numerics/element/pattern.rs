//! Amplitude and kinetic energy of the hourglass pattern, for checks of the result.

use super::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad::{QuadOperators, dot3, section, sums};
use crate::kernel::topology::ElementTopology;
use crate::platform::PortableMath as _;
use crate::state::nodes::Nodes;

/// The element with the largest hourglass displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldedElement {
    pub group: usize,
    pub element: usize,
    /// Displacement of a corner in the pattern, divided by the square root of the element's section area.
    pub fold: f64,
}

/// Returns the quadrilateral with the largest hourglass displacement; `None` without quadrilaterals. The pattern is
/// that of Flanagan and Belytschko 1981 (Int. J. Numer. Meth. Eng. 17, 679, eq. 22) in the current configuration. It is
/// orthogonal to linear fields, i.e. to rotations and uniform strains of any size.
pub fn most_folded(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> Option<FoldedElement> {
    let of_group = |(group, elements): (usize, &dyn ElementGroup)| {
        let alive = (0..elements.len()).filter(|&e| !elements.is_deleted(e));
        let folds = alive.filter_map(|e| Some((e, fold_ratio(quadrilateral(elements, e)?, nodes))));
        let largest = folds.filter(|(_, fold)| fold.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map(|(element, fold)| FoldedElement { group, element, fold })
    };
    groups.iter().map(|g| &**g).enumerate().filter_map(of_group).max_by(|a, b| a.fold.total_cmp(&b.fold))
}

/// Returns the node indices of an element if it is a quadrilateral.
fn quadrilateral(group: &dyn ElementGroup, element: usize) -> Option<[usize; 4]> {
    (group.topology() == ElementTopology::Quadrilateral)
        .then(|| group.cells(element).next())?
        .map(|c| c.inline_map(|n| n as usize))
}

fn fold_ratio(corners: [usize; 4], nodes: &Nodes) -> f64 {
    let places = corners.inline_map(|n| nodes[n].place());
    let moved = [0, 1].inline_map(|axis| [0, 1, 2, 3].inline_map(|i| places[i][axis] - nodes.start[corners[i]][axis]));
    pattern_amplitude(places, moved) / section(places.inline_map(|p| p[0]), places.inline_map(|p| p[1])).sqrt()
}

/// Returns the displacement of a corner in the pattern, from displacements of the corners along both axes.
fn pattern_amplitude(places: [[f64; 2]; 4], corners: [[f64; 4]; 2]) -> f64 {
    let (r, z) = (sums(places.inline_map(|p| p[0])), sums(places.inline_map(|p| p[1])));
    let g = QuadOperators::of::<true>(r, z);
    let shape = g.pattern([r[3], z[3]]).inline_map(|part| part / g.volume);
    let [along_r, along_z] = corners.inline_map(|u| {
        let [_, first, second, pattern] = sums(u);
        0.25 * dot3(shape, [first, second, pattern])
    });
    along_r.portable_hypot(along_z)
}

/// Kinetic energy in the hourglass pattern.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HourglassMotion {
    /// Kinetic energy in the pattern, summed over all quadrilaterals.
    pub kinetic: f64,
    /// Kinetic energy of the corners relative to their mean velocity, summed over all quadrilaterals.
    pub relative: f64,
    /// Group and element with the largest energy in the pattern.
    pub most: (usize, usize),
}

/// Returns the kinetic energy in the pattern; each corner has a quarter of its node's mass.
pub fn hourglass_motion(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> HourglassMotion {
    let (mut sum, mut largest) = (HourglassMotion::default(), 0.0);
    for (group, elements) in groups.iter().enumerate() {
        for element in (0..elements.len()).filter(|&e| !elements.is_deleted(e)) {
            let Some(corners) = quadrilateral(&**elements, element) else { break };
            let [pattern, relative] = rates(corners, nodes);
            // Triangles have no pattern; the result of a degenerate element may be NaN.
            if !(pattern >= 0.0 && relative < f64::INFINITY) {
                continue;
            }
            sum.kinetic += pattern;
            sum.relative += relative;
            if pattern > largest {
                (largest, sum.most) = (pattern, (group, element));
            }
        }
    }
    sum
}

/// Returns the kinetic energy that one element has in the hourglass pattern, and the kinetic energy of its corners
/// relative to their mean velocity.
fn rates(corners: [usize; 4], nodes: &Nodes) -> [f64; 2] {
    let quarter = 0.125 * corners.iter().map(|&n| 0.25 * nodes.mass[n]).sum::<f64>();
    let velocity = [corners.inline_map(|n| nodes[n].v_r), corners.inline_map(|n| nodes[n].v_z)];
    let squares = velocity.inline_map(|v| {
        let mean = 0.25 * v.iter().sum::<f64>();
        v.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()
    });
    let rate = pattern_amplitude(corners.inline_map(|n| nodes[n].place()), velocity);
    [4.0 * quarter * rate * rate, quarter * (squares[0] + squares[1])]
}

#[cfg(test)]
mod tests {
    use super::{fold_ratio, rates};
    use crate::state::nodes::{Node, Nodes};

    fn moved(to: [[f64; 2]; 4]) -> f64 {
        let square = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        let node = |[r, z]: [f64; 2]| Node { r, z, v_r: 0.0, v_z: 0.0 };
        let mut nodes = Nodes::new(square.map(node).to_vec(), vec![1.0; 4]);
        (0..4).for_each(|i| nodes[i] = node(to[i]));
        fold_ratio([0, 1, 2, 3], &nodes)
    }

    #[test]
    fn linear_motion_has_no_hourglass_part() {
        // Rotated by a right angle, stretched and sheared.
        assert!(moved([[5.0, 1.0], [5.5, 3.0], [3.5, 3.5], [3.0, 1.5]]) < 1e-15);
        assert!((moved([[1.1, 0.0], [1.9, 0.0], [2.1, 1.0], [0.9, 1.0]]) - 0.1).abs() < 1e-2);
    }

    #[test]
    fn hourglass_energy_is_separated_from_strain_energy() {
        let square = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        let rates = |v: [f64; 4]| {
            let node = |i: usize| Node { r: square[i][0], z: square[i][1], v_r: 7.0, v_z: 3.0 + v[i] };
            rates([0, 1, 2, 3], &Nodes::new([0, 1, 2, 3].map(node).to_vec(), vec![4.0; 4]))
        };
        // Four corners of mass 1 at a speed of 2.
        let [pattern, relative] = rates([2.0, -2.0, 2.0, -2.0]);
        assert!((pattern - 8.0).abs() < 1e-12 && (relative - 8.0).abs() < 1e-12, "{pattern} {relative}");
        let [pattern, relative] = rates([2.0, 2.0, -2.0, -2.0]);
        assert!(pattern < 1e-25 && (relative - 8.0).abs() < 1e-12, "{pattern} {relative}");
    }
}
