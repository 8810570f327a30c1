//! Distortion control (`*SECTION CONTROLS, DISTORTION CONTROL=YES`): forces that keep corners of elements from passing the
//! line between their neighbours, where the element would turn inside out (ABAQUS Analysis User's Guide, "Section
//! controls"). Never here: which elements are controlled, stress.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::platform::PortableMath as _;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// The share of a corner's velocity towards its line that one increment takes away; so small because four elements may act
/// on a node at once, and two is where a dashpot no longer is stable.
const GRIP: f64 = 0.2;
/// The share of the way back to the offset that a corner is led over one stable increment of the start; by that time and
/// not by the present one, which falls as elements shrink, so that no corner is thrown out.
const LEAD: f64 = 0.05;
/// While a force acts, the increment is shorter by this factor: dashpots that take the share g of a velocity each increment
/// leave omega dt < 2 sqrt(1 - g/2), and g is 1.07 where four flat elements press on a node.
const CAUTION: f64 = 1.5;
/// Increments within which a corner may not come to its offset: faster ones are held before.
const AHEAD: f64 = 5.0;

/// An element under control.
#[derive(Clone, Debug, PartialEq)]
pub struct Controlled {
    /// Group and element of the group.
    pub place: (usize, usize),
    /// Corner nodes of one of its quadrilaterals.
    corners: [u32; 4],
    /// One over the masses of the corner nodes.
    softness: [f64; 4],
    /// Distance from the line between its neighbours at which each corner is pushed; 0 for one on that line from the start,
    /// as of a triangle.
    offset: [f64; 4],
    /// Forces at the instant before.
    force: [[f64; 2]; 4],
}

/// Distance of a corner from the line between its neighbours, positive inside; the normal, and where on the line its foot
/// is, 0 at the next corner and 1 at the one before.
fn distance([corner, next, before]: [[f64; 2]; 3]) -> (f64, [f64; 2], f64) {
    let along = [before[0] - next[0], before[1] - next[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let length = square.sqrt();
    let from = [corner[0] - next[0], corner[1] - next[1]];
    // The body lies on the right of the way from the next corner to the one before.
    let normal = [along[1] / length, -along[0] / length];
    let foot = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
    (-(from[0] * normal[0] + from[1] * normal[1]), [-normal[0], -normal[1]], foot)
}

/// Corner, next and before, of the corner `i`.
fn three<T: Copy>(list: &[T; 4], i: usize) -> [T; 3] {
    [list[i], list[(i + 1) % 4], list[(i + 3) % 4]]
}

impl Controlled {
    /// An element at the start; `ratio` is the offset over the distance there.
    fn new(place: (usize, usize), corners: [u32; 4], softness: [f64; 4], at: [[f64; 2]; 4], ratio: f64) -> Self {
        let span = |i: usize| {
            let [a, b, c] = three(&at, i);
            // A side between doubled nodes has no length, and a corner on it nothing to keep.
            let sides = [[a, b], [a, c], [b, c]].inline_map(|[p, q]| (p[0] - q[0]).portable_hypot(p[1] - q[1]));
            let largest = sides.into_iter().fold(0.0, f64::max);
            if sides.into_iter().any(|s| s <= 1e-9 * largest) {
                return 0.0;
            }
            let from_line = distance([a, b, c]).0;
            if from_line > 1e-9 * largest { ratio * from_line } else { 0.0 }
        };
        Controlled { place, corners, softness, offset: [0, 1, 2, 3].inline_map(span), force: [[0.0; 2]; 4] }
    }

    /// Forces on the corners; `None` where no corner is within its offset.
    fn push(&self, places: &[[f64; 2]; 4], velocities: &[[f64; 2]; 4], dt: f64, time: f64) -> Option<[[f64; 2]; 4]> {
        let mut forces = None;
        for i in (0..4).filter(|&i| self.offset[i] > 0.0) {
            let (from_line, normal, foot) = distance(three(places, i));
            let weights = [1.0, foot - 1.0, -foot];
            let motion = three(velocities, i);
            let speed = |v: [f64; 2]| v[0] * normal[0] + v[1] * normal[1];
            let opening: f64 = weights.iter().zip(motion).map(|(w, v)| w * speed(v)).sum();
            let within = self.offset[i] - from_line;
            let wanted = if within > 0.0 { LEAD * within / time.max(dt) } else { within / (AHEAD * dt) };
            if wanted.is_nan() || opening.is_nan() || opening >= wanted {
                continue;
            }
            let softness: f64 = weights.iter().zip(three(&self.softness, i)).map(|(w, s)| w * w * s).sum();
            if softness == 0.0 {
                continue;
            }
            let size = GRIP * (wanted - opening) / (softness * dt);
            let forces = forces.get_or_insert([[0.0; 2]; 4]);
            for (w, c) in weights.into_iter().zip([i, (i + 1) % 4, (i + 3) % 4]) {
                forces[c][0] += w * size * normal[0];
                forces[c][1] += w * size * normal[1];
            }
        }
        forces
    }
}

/// All elements under control.
#[derive(Clone, Debug, Default)]
pub struct DistortionControl {
    list: Vec<Controlled>,
    /// Stable increment at the start, by which corners are led back.
    time: f64,
}

impl DistortionControl {
    /// Takes the quadrilaterals of a group's elements, with the element of each, under control; `ratio` is LENGTH RATIO.
    pub fn add(&mut self, group: usize, cells: impl Iterator<Item = (usize, [u32; 4])>, nodes: &Nodes, ratio: f64) {
        for (element, corners) in cells {
            let at = corners.inline_map(|n| nodes.start[n as usize]);
            let softness = corners.inline_map(|n| nodes.inverse_mass[n as usize]);
            self.list.push(Controlled::new((group, element), corners, softness, at, ratio));
        }
    }

    /// Adds the forces on nodes. Their work over the increment behind, by the trapezoid that books the forces on nodes, is its
    /// own account and not work of the outside. `rate` is one over the increment that elements allow.
    pub(super) fn resist(&mut self, dofs: &mut Dofs, alive: impl Fn((usize, usize)) -> bool, rate: &mut f64) {
        if dofs.nodes.behind == 0.0 {
            self.time = 1.0 / *rate;
            return;
        }
        let dt = dofs.nodes.unbooked();
        let mut active = false;
        for controlled in &mut self.list {
            let nodes = controlled.corners.inline_map(|n| dofs.nodes[n as usize]);
            let (places, velocities) = (nodes.inline_map(|n| [n.r, n.z]), nodes.inline_map(|n| [n.v_r, n.v_z]));
            let mut found = controlled.push(&places, &velocities, dofs.nodes.behind, self.time);
            if found.is_some() && !alive(controlled.place) {
                found = None;
            }
            if found.is_none() && controlled.force == [[0.0; 2]; 4] {
                continue;
            }
            active |= found.is_some();
            let forces = found.unwrap_or_default();
            let mut work = 0.0;
            for (i, &n) in controlled.corners.iter().enumerate() {
                let (now, before) = (forces[i], controlled.force[i]);
                work += 0.5 * dt * ((now[0] + before[0]) * velocities[i][0] + (now[1] + before[1]) * velocities[i][1]);
                dofs.nodes.forces[0][n as usize][0] += now[0];
                dofs.nodes.forces[0][n as usize][1] += now[1];
            }
            dofs.energies.external -= work;
            dofs.energies.distortion -= work;
            controlled.force = forces;
        }
        if active {
            *rate *= CAUTION;
        }
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.list)
    }
}

persist_struct!(DistortionControl { list: fixed, time });

persist_struct!(Controlled { force } derived { place, corners, softness, offset });

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];

    #[test]
    fn corners_know_their_distance() {
        for i in 0..4 {
            let (from_line, normal, foot) = distance(three(&SQUARE, i));
            assert!((from_line - 0.5f64.sqrt()).abs() < 1e-15 && (foot - 0.5).abs() < 1e-15);
            // Along the normal the corner moves away from its line.
            let mut moved = SQUARE;
            moved[i] = [moved[i][0] + 0.1 * normal[0], moved[i][1] + 0.1 * normal[1]];
            assert!((distance(three(&moved, i)).0 - from_line - 0.1).abs() < 1e-15);
        }
    }

    #[test]
    fn forces_push_apart_only_what_comes_too_near_and_keep_momentum() {
        let controlled = Controlled::new((0, 0), [0, 1, 2, 3], [1.0, 0.5, 0.3, 0.2], SQUARE, 0.1);
        let still = [[0.0; 2]; 4];
        assert_eq!(controlled.push(&SQUARE, &still, 1.0, 1.0), None);
        let mut places = SQUARE;
        places[2] = [1.52, 0.52];
        assert!(distance(three(&places, 2)).0 > 0.0);
        let mut velocities = still;
        velocities[2] = [-1.0, -1.0];
        let forces = controlled.push(&places, &velocities, 1.0, 1.0).expect("too near");
        assert!(forces[2][0] > 0.0 && forces[2][1] > 0.0, "{forces:?}");
        let sum = forces.iter().fold([0.0, 0.0], |s, f| [s[0] + f[0], s[1] + f[1]]);
        assert!(sum[0].abs() < 1e-15 && sum[1].abs() < 1e-15, "{sum:?}");
        velocities[2] = [1.0, 1.0];
        assert_eq!(controlled.push(&places, &velocities, 1.0, 1.0), None);
    }

    #[test]
    fn a_triangle_is_not_pushed_at_its_doubled_node() {
        let triangle = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 1.0]];
        let controlled = Controlled::new((0, 0), [0, 1, 2, 2], [1.0; 4], triangle, 0.1);
        assert_eq!(controlled.offset.map(|o| o > 0.0), [true, true, false, false]);
    }
}
