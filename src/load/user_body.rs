//! A body force of the user's routine on deformable elements (`BRNU`, `BZNU`).
//! Never here: how the routine was made or loaded.

use crate::element::body::NodeForce;
use crate::kernel::quad::corner_masses;
use crate::load::user_load::{Shown, UserLoad};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::nodes::Node;
use crate::user::{LoadFailure, MAX_BLOCK};

/// The force a volume that the routine gives at the middle of each element, along r (`jltyp` 1) or z (2).
pub struct BodyUser {
    load: UserLoad,
    axis: usize,
    blocks: Vec<BodyBlock>,
}

struct BodyBlock {
    elements: Vec<[u32; 4]>,
    start: Vec<[f64; 2]>,
    shown: Shown,
}

/// Mean place and velocity of an element's corners.
fn middle(element: [u32; 4], nodes: &[Node]) -> [f64; 4] {
    let corners = element.map(|n| nodes[n as usize].as_array());
    [0, 1, 2, 3].map(|k| 0.25 * ((corners[0][k] + corners[1][k]) + (corners[2][k] + corners[3][k])))
}

impl BodyUser {
    /// The load on elements whose nodes are at these places at the start.
    pub fn new(load: UserLoad, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        let block = |part: &[[u32; 4]]| {
            let mut shown = Shown::new(part.len());
            (0..part.len()).for_each(|i| shown.set_normal(i, [0.0; 2], false));
            let start = part.iter().map(|e| middle(*e, nodes)).map(|[r, z, ..]| [r, z]).collect();
            BodyBlock { elements: part.to_vec(), start, shown }
        };
        let axis = if load.load_type == 1 { 0 } else { 1 };
        BodyUser { axis, load, blocks: elements.chunks(MAX_BLOCK).map(block).collect() }
    }
}

impl BodyBlock {
    fn evaluate(&mut self, load: &UserLoad, nodes: &[Node], now: &Instant, amplitude: f64) -> Result<(), LoadFailure> {
        let n = self.elements.len();
        self.shown.forget();
        for (i, (&element, start)) in self.elements.iter().zip(&self.start).enumerate() {
            let [r, z, v_r, v_z] = middle(element, nodes);
            for (axis, (place, velocity)) in [(r, v_r), (z, v_z)].into_iter().enumerate() {
                self.shown.coordinates[axis * n + i] = place;
                self.shown.motion[axis * n + i] = velocity;
                self.shown.motion[(2 + axis) * n + i] = place - start[axis];
            }
        }
        self.shown.call(load, now, amplitude)?;
        let finite = self.shown.pressure().iter().all(|p| p.is_finite());
        self.shown.accept(finite)
    }
}

impl NodeForce for BodyUser {
    fn see_accelerations(&mut self, acceleration: &[[f64; 2]]) {
        for block in &mut self.blocks {
            let n = block.elements.len();
            for (i, element) in block.elements.iter().enumerate() {
                let [a, b, c, d] = element.map(|n| acceleration[n as usize]);
                for axis in 0..2 {
                    let mean = 0.25 * ((a[axis] + b[axis]) + (c[axis] + d[axis]));
                    block.shown.motion[(4 + axis) * n + i] = mean;
                }
            }
        }
    }

    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let amplitude = self.load.magnitude.amplitude(now);
        for (i, block) in self.blocks.iter_mut().enumerate() {
            let called = block.evaluate(&self.load, nodes, now, amplitude);
            called.map_err(|failure| block.shown.failure(&self.load, i * MAX_BLOCK, now, &failure))?;
            for (element, &force) in block.elements.iter().zip(block.shown.pressure()) {
                // The part of the volume that belongs to each corner.
                let shares = corner_masses(element.map(|n| nodes[n as usize].place()), 1.0);
                for (&node, share) in element.iter().zip(shares) {
                    forces[node as usize][self.axis] += force * share;
                }
            }
        }
        Ok(())
    }
}

impl Persist for BodyBlock {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let BodyBlock { elements: _, start: _, shown } = self;
        shown.persist(archive);
    }
}

impl Persist for BodyUser {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let BodyUser { load: _, axis: _, blocks } = self;
        blocks.as_mut_slice().persist(archive);
    }
}
