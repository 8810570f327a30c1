//! The tunnel behind the nose of what deforms: how far its wall has been pushed, by place along z.
//! Never here: what acts on what meets the wall.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::mesh::surface::Face;
use crate::state::archive::persist_struct;

/// Radii of the wall in slices of one thickness. It remembers as many slices as bodies are long: the nearest ones to what moves.
#[derive(Clone, Debug)]
pub(super) struct Tunnel {
    thickness: f64,
    slices: Vec<Slice>,
}

/// One slice: its number along z and the radius to which it has been opened.
#[derive(Clone, Copy, Debug, Default)]
struct Slice {
    number: f64,
    radius: f64,
}

impl Tunnel {
    /// For faces of this least length on bodies of this length.
    pub(super) fn new(face: f64, length: f64) -> Self {
        let thickness = 0.5 * face;
        // Bodies get longer by some; beyond that the oldest slices are forgotten.
        let count = (2.0 * length / thickness).ceil().clamp(16.0, 1e6) as usize;
        Tunnel { thickness, slices: vec![Slice::default(); count] }
    }

    /// Whether a face that moves along z by this sign (or not at all, 0) meets the wall: it is no narrower than the wall a slice ahead of it. At the
    /// place of the face itself the wall is as wide as the face.
    pub(super) fn is_met_by(&self, face: &Face, sign: f64) -> bool {
        let [r, z] = face.middle();
        let place = (z + sign * self.thickness) / self.thickness - 0.5;
        let (below, part) = (place.floor(), place - place.floor());
        let [low, high] = [0.0, 1.0].inline_map(|more| self.radius(below + more));
        r >= (low + part * (high - low)) * (1.0 - 1e-9)
    }

    /// Pushes the wall to a face, where it is narrower.
    pub(super) fn widen(&mut self, face: &Face) {
        let [a, b] = face.ends;
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let [first, last] = [low[1], high[1]].inline_map(|z| (z / self.thickness - 0.5).ceil());
        let mut number = first;
        while number < last {
            let z = (number + 0.5) * self.thickness;
            let part = (z - low[1]) / (high[1] - low[1]);
            self.open(number, low[0] + part * (high[0] - low[0]));
            number += 1.0;
        }
    }

    fn radius(&self, number: f64) -> f64 {
        let slice = self.slices[self.place(number)];
        if slice.number == number { slice.radius } else { 0.0 }
    }

    fn open(&mut self, number: f64, radius: f64) {
        let place = self.place(number);
        let slice = &mut self.slices[place];
        if slice.number != number {
            *slice = Slice { number, radius: 0.0 };
        }
        slice.radius = slice.radius.max(radius);
    }

    fn place(&self, number: f64) -> usize {
        number.rem_euclid(self.slices.len() as f64) as usize
    }

    pub(super) fn bytes(&self) -> usize {
        heap_bytes(&self.slices)
    }
}

persist_struct!(Slice { number, radius });

persist_struct!(Tunnel { slices: fixed } derived { thickness });

#[cfg(test)]
mod tests {
    use super::Tunnel;
    use crate::mesh::surface::Face;

    fn face(ends: [[f64; 2]; 2]) -> Face {
        Face { nodes: [0, 1], ends, normal: [1.0, 0.0] }
    }

    /// A shank of r = 2 passes and springs back to 1.9: it meets the wall again at 2.
    #[test]
    fn what_is_narrower_than_the_wall_does_not_meet_it() {
        let mut tunnel = Tunnel::new(1.0, 10.0);
        let shank = |r: f64| face([[r, 0.0], [r, 3.0]]);
        assert!(tunnel.is_met_by(&shank(0.5), -1.0), "nothing has been opened yet");
        tunnel.widen(&shank(2.0));
        assert!(!tunnel.is_met_by(&shank(1.9), -1.0));
        assert!(tunnel.is_met_by(&shank(2.0), -1.0));
        assert!(tunnel.is_met_by(&shank(2.1), -1.0));
        // A level face at the front of the shank meets what is ahead.
        assert!(tunnel.is_met_by(&face([[0.0, 0.0], [2.0, 0.0]]), -1.0));
    }

    /// What is further behind than bodies are long is forgotten, and nothing else.
    #[test]
    fn slices_are_used_again() {
        let mut tunnel = Tunnel::new(1.0, 10.0);
        (0..100).for_each(|i| tunnel.widen(&face([[2.0, -f64::from(i)], [2.0, 1.0 - f64::from(i)]])));
        let at = |z: f64| face([[1.0, z], [1.0, z + 1.0]]);
        assert!(!tunnel.is_met_by(&at(-95.0), -1.0));
        assert!(tunnel.is_met_by(&at(-40.0), -1.0));
    }
}
