//! Dilation of triangles averaged over their nodes, so that what keeps its volume can still deform: each triangle takes the mean
//! of its nodes, each node the mean of the triangles around it (Bonet and Burton 1998, Commun. Numer. Meth. Eng. 14, 437).
//! Never here: stresses.

use super::group::ElementGroup;
use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad::dilation;
use crate::state::nodes::Nodes;

/// The triangles of one group.
#[derive(Clone, Debug)]
pub struct Averaging {
    /// Each triangle: its element in the group, and its nodes by their place in `nodes`.
    triangles: Vec<(u32, [u32; 3])>,
    nodes: Vec<u32>,
    /// Of each node, the volume around it and by how much it grew over the increment behind.
    around: Vec<[f64; 2]>,
    /// Of each triangle the same, no volume once it is deleted.
    own: Vec<[f64; 2]>,
    /// What each element's volumetric strain increment lacks to be the averaged one, block by block; 0 for quadrilaterals.
    lacking: Vec<Lanes>,
}

impl Averaging {
    /// Of the triangles among the elements of a group; `None` if there is none.
    pub fn new(corners: &[[u32; 4]]) -> Option<Averaging> {
        let is_triangle = |c: &[u32; 4]| c[2] == c[3];
        let found = corners.iter().enumerate().filter(|(_, c)| is_triangle(c));
        let nodes: Vec<u32> = sorted_unique(found.clone().flat_map(|(_, c)| c[..3].to_vec()));
        let place = |node: &u32| nodes.partition_point(|n| n < node) as u32;
        let triangles: Vec<_> = found.map(|(e, c)| (e as u32, [place(&c[0]), place(&c[1]), place(&c[2])])).collect();
        (!triangles.is_empty()).then(|| Averaging {
            own: vec![[0.0; 2]; triangles.len()],
            around: vec![[0.0; 2]; nodes.len()],
            lacking: vec![[0.0; LANES]; corners.len().div_ceil(LANES)],
            triangles,
            nodes,
        })
    }

    /// What the strains of the increment behind lack, block by block of the group. A third of a triangle's volume belongs to
    /// each of its nodes.
    pub fn measure(&mut self, group: &dyn ElementGroup, nodes: &Nodes) -> &[Lanes] {
        self.around.fill([0.0; 2]);
        for (&(element, corners), own) in self.triangles.iter().zip(&mut self.own) {
            let [a, b, c] = corners.inline_map(|n| nodes[self.nodes[n as usize] as usize].as_array());
            let deleted = group.is_deleted(element as usize);
            *own = if deleted { [0.0; 2] } else { dilation::<false>([a, b, c, c], nodes.behind) };
            for n in corners {
                let sum = &mut self.around[n as usize];
                *sum = [sum[0] + own[0], sum[1] + own[1]];
            }
        }
        for (&(element, corners), [volume, growth]) in self.triangles.iter().zip(&self.own) {
            let of_nodes =
                corners.inline_map(|n| self.around[n as usize]).inline_map(|[volume, growth]| growth / volume);
            let mean = (of_nodes[0] + of_nodes[1] + of_nodes[2]) / 3.0;
            let lacking = if *volume > 0.0 { mean - growth / volume } else { 0.0 };
            self.lacking[element as usize / LANES][element as usize % LANES] = lacking;
        }
        &self.lacking
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.triangles)
            + size_of_val(&*self.nodes)
            + size_of_val(&*self.around)
            + size_of_val(&*self.own)
            + size_of_val(&*self.lacking)
    }
}
