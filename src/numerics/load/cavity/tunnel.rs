//! The tunnel that a deformable body opens: the radius of its wall as a function of z.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::mesh::surface::CurrentFace;
use crate::state::archive::Persist;

/// Wall radii in slices of equal thickness. Slices are reused in a ring buffer that covers twice the initial length of
/// the body.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: slices; derived: thickness)]
pub(super) struct TunnelWall {
    thickness: f64,
    slices: Vec<WallSlice>,
}

/// One slice: its index along z and the radius to which it was opened.
#[derive(Clone, Copy, Debug, Default, Persist)]
struct WallSlice {
    number: f64,
    radius: f64,
}

impl TunnelWall {
    /// Creates a tunnel for bodies of this length whose shortest face has length `face`.
    pub(super) fn new(face: f64, length: f64) -> Self {
        let thickness = 0.5 * face;
        // Bodies may become longer than they were; the oldest slices are overwritten after that.
        let count = (2.0 * length / thickness).ceil().clamp(16.0, 1e6) as usize;
        TunnelWall { thickness, slices: vec![WallSlice::default(); count] }
    }

    /// Returns whether a face touches the wall: its radius is at least that of the wall one slice ahead in the
    /// direction of motion `sign` (0 at rest). At its own position the wall is as wide as the face.
    pub(super) fn is_touched_by(&self, face: &CurrentFace, sign: f64) -> bool {
        let [r, z] = face.middle();
        let position = (z + sign * self.thickness) / self.thickness - 0.5;
        let (below, part) = (position.floor(), position - position.floor());
        let [low, high] = [0.0, 1.0].inline_map(|more| self.radius(below + more));
        r >= (low + part * (high - low)) * (1.0 - 1e-9)
    }

    /// Widens the wall to a face where it is narrower.
    pub(super) fn widen(&mut self, face: &CurrentFace) {
        let [a, b] = face.ends;
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let [first, last] = [low[1], high[1]].inline_map(|z| (z / self.thickness - 0.5).ceil());
        // Later slices overwrite those before the last `count`.
        let count = self.slices.len() as f64;
        let first = first.max(last - count);
        for offset in 0..(last - first).clamp(0.0, count) as usize {
            let number = first + offset as f64;
            let z = (number + 0.5) * self.thickness;
            let part = (z - low[1]) / (high[1] - low[1]);
            self.open(number, low[0] + part * (high[0] - low[0]));
        }
    }

    fn radius(&self, number: f64) -> f64 {
        let slice = self.slices[self.place(number)];
        if slice.number == number { slice.radius } else { 0.0 }
    }

    fn open(&mut self, number: f64, radius: f64) {
        let position = self.place(number);
        let slice = &mut self.slices[position];
        if slice.number != number {
            *slice = WallSlice { number, radius: 0.0 };
        }
        slice.radius = slice.radius.max(radius);
    }

    fn place(&self, number: f64) -> usize {
        number.rem_euclid(self.slices.len() as f64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::TunnelWall;
    use crate::mesh::surface::CurrentFace;

    fn face(ends: [[f64; 2]; 2]) -> CurrentFace {
        CurrentFace { nodes: [0, 1], ends, normal: [1.0, 0.0] }
    }

    /// A shank of r = 2 passes and springs back to 1.9; it touches the wall again at 2.
    #[test]
    fn face_narrower_than_the_wall_is_not_loaded() {
        let mut tunnel = TunnelWall::new(1.0, 10.0);
        let shank = |r: f64| face([[r, 0.0], [r, 3.0]]);
        assert!(tunnel.is_touched_by(&shank(0.5), -1.0), "nothing has been opened yet");
        tunnel.widen(&shank(2.0));
        assert!(!tunnel.is_touched_by(&shank(1.9), -1.0));
        assert!(tunnel.is_touched_by(&shank(2.0), -1.0));
        assert!(tunnel.is_touched_by(&shank(2.1), -1.0));
        // A face normal to the axis at the front of the shank touches the material ahead.
        assert!(tunnel.is_touched_by(&face([[0.0, 0.0], [2.0, 0.0]]), -1.0));
    }

    /// Only slices further away than the length of the buffer are overwritten.
    #[test]
    fn slices_are_reused_in_a_ring() {
        let mut tunnel = TunnelWall::new(1.0, 10.0);
        (0..100).for_each(|i| tunnel.widen(&face([[2.0, -f64::from(i)], [2.0, 1.0 - f64::from(i)]])));
        let face_at = |z: f64| face([[1.0, z], [1.0, z + 1.0]]);
        assert!(!tunnel.is_touched_by(&face_at(-95.0), -1.0));
        assert!(tunnel.is_touched_by(&face_at(-40.0), -1.0));
    }
}
