//! Averaged nodal dilation of triangles against volumetric locking: each node takes the mean dilation of its triangles,
//! each triangle the mean of its nodes (Bonet and Burton 1998, Commun. Numer. Meth. Eng. 14, 437).

use super::group::ElementGroup;
use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::lists::{Memory, sorted_unique};
use crate::kernel::quad::dilation;
use crate::kernel::shape::is_triangle;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// Returns the factor of damage on the stress of an element, the weight of its volume in the means: with it, the
/// averaged pressures act with the transposed operator.
fn stress_factor(group: &dyn ElementGroup, element: usize) -> f64 {
    if group.is_deleted(element) {
        return 0.0;
    }
    1.0 - group.value(element, Variable::Degradation.into()).unwrap_or(0.0)
}

/// Averaging of the triangles of one group.
#[derive(Clone, Debug, Memory)]
pub struct DilationAveraging {
    /// Element of each triangle in the group, and its nodes as indices into `nodes`.
    triangles: Vec<(u32, [u32; 3])>,
    nodes: Vec<u32>,
    /// Volume around each node, and its growth over the previous increment.
    around: Vec<[f64; 2]>,
    /// Volume of each triangle and its growth, times the factor of damage on its stress; zero for a deleted triangle.
    own: Vec<[f64; 2]>,
    /// Averaged minus own volumetric strain increment of each element, block by block; 0 for quadrilaterals.
    correction: Vec<Lanes>,
}

impl DilationAveraging {
    /// Creates the averaging for the triangles of a group; `None` if there are none.
    pub fn new(corners: &[[u32; 4]]) -> Option<DilationAveraging> {
        let triangular = corners.iter().enumerate().filter(|(_, c)| is_triangle(c));
        let nodes: Vec<u32> = sorted_unique(triangular.clone().flat_map(|(_, c)| c[..3].to_vec()));
        let index_of = |node: &u32| nodes.partition_point(|n| n < node) as u32;
        let triangles: Vec<_> =
            triangular.map(|(e, c)| (e as u32, [index_of(&c[0]), index_of(&c[1]), index_of(&c[2])])).collect();
        (!triangles.is_empty()).then(|| DilationAveraging {
            own: vec![[0.0; 2]; triangles.len()],
            around: vec![[0.0; 2]; nodes.len()],
            correction: vec![[0.0; LANES]; corners.len().div_ceil(LANES)],
            triangles,
            nodes,
        })
    }

    /// Returns the averaged minus own volumetric strain of the previous increment, block by block. A third of a
    /// triangle's volume belongs to each of its nodes. Equation (5.15).
    pub fn measure(&mut self, group: &dyn ElementGroup, nodes: &Nodes) -> &[Lanes] {
        self.around.fill([0.0; 2]);
        for (&(element, corners), own) in self.triangles.iter().zip(&mut self.own) {
            let [a, b, c] = corners.inline_map(|n| nodes[self.nodes[n as usize] as usize].as_array());
            let share = stress_factor(group, element as usize);
            let measured = dilation::<false>([a, b, c, c], nodes.previous_dt);
            *own = if share > 0.0 { [share * measured[0], share * measured[1]] } else { [0.0; 2] };
            for n in corners {
                let sum = &mut self.around[n as usize];
                *sum = [sum[0] + own[0], sum[1] + own[1]];
            }
        }
        for (&(element, corners), [volume, growth]) in self.triangles.iter().zip(&self.own) {
            let of_nodes =
                corners.inline_map(|n| self.around[n as usize]).inline_map(|[volume, growth]| growth / volume);
            let mean = (of_nodes[0] + of_nodes[1] + of_nodes[2]) / 3.0;
            let correction = if *volume > 0.0 { mean - growth / volume } else { 0.0 };
            self.correction[element as usize / LANES][element as usize % LANES] = correction;
        }
        &self.correction
    }
}
