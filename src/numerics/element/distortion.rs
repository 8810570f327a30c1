//! Distortion control (`*SECTION CONTROLS, DISTORTION CONTROL=YES`): forces that prevent corners of elements from
//! crossing the line between their neighbours, where the element would invert (ABAQUS Analysis User's Guide, "Section
//! controls").

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::platform::PortableMath as _;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Fraction of a corner's approach velocity that one increment removes. It is small because four elements may act on a
/// node at once, and a dashpot becomes unstable at two.
const GRIP: f64 = 0.2;
/// Fraction of the distance back to the offset that a corner covers in one initial stable time increment. The initial
/// value is used because the current one decreases as elements shrink; corners would then be ejected.
const LEAD: f64 = 0.05;
/// Divisor of the time increment while a force acts. Dashpots that remove the fraction g of a velocity per increment
/// require ω dt < 2 sqrt(1 - g/2); g is 1.07 where four flat elements act on a node.
const CAUTION: f64 = 1.5;
/// Smallest number of increments in which a corner may reach its offset; faster corners are decelerated earlier.
const AHEAD: f64 = 5.0;

/// An element under distortion control.
#[derive(Clone, Debug, PartialEq, Persist, Memory)]
#[persist(derived: place, corners, inverse_mass, offset)]
pub struct ControlledElement {
    /// Index of the element group, and of the element in it.
    pub place: (usize, usize),
    /// Corner nodes of one quadrilateral cell of the element.
    corners: [u32; 4],
    /// Inverse masses of the corner nodes.
    inverse_mass: [f64; 4],
    /// Distance of each corner from the line between its neighbours below which it is pushed; 0 for a corner that is
    /// initially on this line, as in a triangle.
    offset: [f64; 4],
    /// Forces at the previous instant.
    force: [[f64; 2]; 4],
}

/// A corner in relation to the line between its neighbours.
struct CornerHeight {
    /// Distance from the line, positive inside.
    distance: f64,
    normal: [f64; 2],
    /// Position of the projection on the line: 0 at the next corner, 1 at the previous one.
    position: f64,
}

/// Returns the height of a corner over the line between the next and the previous corner.
fn height([corner, next, previous]: [[f64; 2]; 3]) -> CornerHeight {
    let along = [previous[0] - next[0], previous[1] - next[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let length = square.sqrt();
    let from = [corner[0] - next[0], corner[1] - next[1]];
    // The element is to the right of the direction from the next to the previous corner.
    let normal = [along[1] / length, -along[0] / length];
    let position = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
    let distance = -(from[0] * normal[0] + from[1] * normal[1]);
    CornerHeight { distance, normal: [-normal[0], -normal[1]], position }
}

/// Returns the values at corner `i`, the next and the previous corner.
fn three<T: Copy>(list: &[T; 4], i: usize) -> [T; 3] {
    [list[i], list[(i + 1) % 4], list[(i + 3) % 4]]
}

impl ControlledElement {
    /// Creates the control of an element in the initial configuration; `ratio` is the offset over the initial distance.
    fn new(place: (usize, usize), corners: [u32; 4], softness: [f64; 4], at: [[f64; 2]; 4], ratio: f64) -> Self {
        let span = |i: usize| {
            let [a, b, c] = three(&at, i);
            // A side between coincident nodes has no length; its corners need no control.
            let sides = [[a, b], [a, c], [b, c]].inline_map(|[p, q]| (p[0] - q[0]).portable_hypot(p[1] - q[1]));
            let largest = sides.into_iter().fold(0.0, f64::max);
            if sides.into_iter().any(|s| s <= 1e-9 * largest) {
                return 0.0;
            }
            let from_line = height([a, b, c]).distance;
            if from_line > 1e-9 * largest { ratio * from_line } else { 0.0 }
        };
        ControlledElement {
            place,
            corners,
            inverse_mass: softness,
            offset: [0, 1, 2, 3].inline_map(span),
            force: [[0.0; 2]; 4],
        }
    }

    /// Returns the forces on the corners; `None` if none acts.
    fn corner_forces(
        &self,
        places: &[[f64; 2]; 4],
        velocities: &[[f64; 2]; 4],
        dt: f64,
        time: f64,
    ) -> Option<[[f64; 2]; 4]> {
        let mut forces = None;
        for i in (0..4).filter(|&i| self.offset[i] > 0.0) {
            let CornerHeight { distance, normal, position } = height(three(places, i));
            let weights = [1.0, position - 1.0, -position];
            let motion = three(velocities, i);
            let speed = |v: [f64; 2]| v[0] * normal[0] + v[1] * normal[1];
            let opening: f64 = weights.iter().zip(motion).map(|(w, v)| w * speed(v)).sum();
            let within = self.offset[i] - distance;
            let target = if within > 0.0 { LEAD * within / time.max(dt) } else { within / (AHEAD * dt) };
            if target.is_nan() || opening.is_nan() || opening >= target {
                continue;
            }
            let softness: f64 = weights.iter().zip(three(&self.inverse_mass, i)).map(|(w, s)| w * w * s).sum();
            if softness == 0.0 {
                continue;
            }
            let size = GRIP * (target - opening) / (softness * dt);
            let forces = forces.get_or_insert([[0.0; 2]; 4]);
            for (w, c) in weights.into_iter().zip([i, (i + 1) % 4, (i + 3) % 4]) {
                forces[c][0] += w * size * normal[0];
                forces[c][1] += w * size * normal[1];
            }
        }
        forces
    }
}

/// All elements under distortion control.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: list)]
pub struct DistortionControl {
    list: Vec<ControlledElement>,
    /// Initial stable time increment.
    time: f64,
}

impl DistortionControl {
    /// Adds the cells of a group's elements, each with the element index; `ratio` is LENGTH RATIO.
    pub fn add(&mut self, group: usize, cells: impl Iterator<Item = (usize, [u32; 4])>, nodes: &Nodes, ratio: f64) {
        for (element, corners) in cells {
            let starts = corners.inline_map(|n| nodes.start[n as usize]);
            let softness = corners.inline_map(|n| nodes.inverse_mass[n as usize]);
            self.list.push(ControlledElement::new((group, element), corners, softness, starts, ratio));
        }
    }

    /// Continues the control of the same elements before a new mesh of a body without it.
    pub(super) fn follow_new_mesh(&mut self, previous: &DistortionControl) {
        self.time = previous.time;
        self.list.iter_mut().zip(&previous.list).for_each(|(element, previous)| element.force = previous.force);
    }

    /// Starts a run, or continues after a new mesh of a body without control: the forces are those of the same instant before it.
    fn start(&mut self, dofs: &mut Dofs, rate: &mut f64) {
        if self.time == 0.0 {
            self.time = 1.0 / *rate;
            return;
        }
        let mut active = false;
        for ControlledElement { corners, force, .. } in self.list.iter().filter(|e| e.force != [[0.0; 2]; 4]) {
            active = true;
            for (n, force) in corners.iter().zip(force) {
                dofs.nodes.forces[0][*n as usize][0] += force[0];
                dofs.nodes.forces[0][*n as usize][1] += force[1];
            }
        }
        if active {
            *rate *= CAUTION;
        }
    }

    /// Adds the control forces to the nodal forces. Their work over the previous increment, by the trapezoidal rule as
    /// for all nodal forces, has its own energy and is subtracted from the external work. `rate` is one over the time
    /// increment that elements allow.
    pub(super) fn add_forces(&mut self, dofs: &mut Dofs, alive: impl Fn((usize, usize)) -> bool, rate: &mut f64) {
        if dofs.nodes.previous_dt == 0.0 {
            self.start(dofs, rate);
            return;
        }
        let dt = dofs.nodes.unaccounted_dt();
        let mut active = false;
        for controlled in &mut self.list {
            let nodes = controlled.corners.inline_map(|n| dofs.nodes[n as usize]);
            let (places, velocities) = (nodes.inline_map(|n| [n.r, n.z]), nodes.inline_map(|n| [n.v_r, n.v_z]));
            let mut corner_forces = controlled.corner_forces(&places, &velocities, dofs.nodes.previous_dt, self.time);
            if corner_forces.is_some() && !alive(controlled.place) {
                corner_forces = None;
            }
            if corner_forces.is_none() && controlled.force == [[0.0; 2]; 4] {
                continue;
            }
            active |= corner_forces.is_some();
            let forces = corner_forces.unwrap_or_default();
            let mut work = 0.0;
            for (i, &n) in controlled.corners.iter().enumerate() {
                let (now, previous) = (forces[i], controlled.force[i]);
                work +=
                    0.5 * dt * ((now[0] + previous[0]) * velocities[i][0] + (now[1] + previous[1]) * velocities[i][1]);
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
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];

    #[test]
    fn distances_and_normals_of_a_square_are_exact() {
        for i in 0..4 {
            let CornerHeight { distance, normal, position } = height(three(&SQUARE, i));
            assert!((distance - 0.5f64.sqrt()).abs() < 1e-15 && (position - 0.5).abs() < 1e-15);
            // The normal points away from the line.
            let mut moved = SQUARE;
            moved[i] = [moved[i][0] + 0.1 * normal[0], moved[i][1] + 0.1 * normal[1]];
            assert!((height(three(&moved, i)).distance - distance - 0.1).abs() < 1e-15);
        }
    }

    #[test]
    fn forces_act_only_within_the_offset_and_conserve_momentum() {
        let controlled = ControlledElement::new((0, 0), [0, 1, 2, 3], [1.0, 0.5, 0.3, 0.2], SQUARE, 0.1);
        let still = [[0.0; 2]; 4];
        assert_eq!(controlled.corner_forces(&SQUARE, &still, 1.0, 1.0), None);
        let mut places = SQUARE;
        places[2] = [1.52, 0.52];
        assert!(height(three(&places, 2)).distance > 0.0);
        let mut velocities = still;
        velocities[2] = [-1.0, -1.0];
        let forces = controlled.corner_forces(&places, &velocities, 1.0, 1.0).expect("too near");
        assert!(forces[2][0] > 0.0 && forces[2][1] > 0.0, "{forces:?}");
        let sum = forces.iter().fold([0.0, 0.0], |s, f| [s[0] + f[0], s[1] + f[1]]);
        assert!(sum[0].abs() < 1e-15 && sum[1].abs() < 1e-15, "{sum:?}");
        velocities[2] = [1.0, 1.0];
        assert_eq!(controlled.corner_forces(&places, &velocities, 1.0, 1.0), None);
    }

    /// The force of an increment removes a fifth of the velocity at which a corner approaches the line. The velocity is that of
    /// the distance when the corners move.
    #[test]
    fn force_of_an_increment_removes_a_fifth_of_the_approach_velocity() {
        let inverse_mass = [1.0, 0.5, 0.3, 0.2];
        let controlled = ControlledElement::new((0, 0), [0, 1, 2, 3], inverse_mass, SQUARE, 0.1);
        let mut places = SQUARE;
        places[2] = [1.52, 0.52];
        let rate = |velocities: &[[f64; 2]; 4]| {
            let moved = |time: f64| {
                let place = |i: usize| [0, 1].map(|axis| places[i][axis] + time * velocities[i][axis]);
                height(three(&[0, 1, 2, 3].map(place), 2)).distance
            };
            (moved(1e-6) - moved(-1e-6)) / 2e-6
        };
        let velocities = [[0.1, 0.0], [0.0, 0.2], [-1.0, -1.0], [0.3, 0.0]];
        let dt = 0.25;
        // With a long time for the way back, the target is a corner at rest.
        let forces = controlled.corner_forces(&places, &velocities, dt, 1e12).expect("too near");
        let after = |i: usize| [0, 1].map(|axis| velocities[i][axis] + dt * inverse_mass[i] * forces[i][axis]);
        let ratio = rate(&[0, 1, 2, 3].map(after)) / rate(&velocities);
        assert!((ratio - 0.8).abs() < 1e-6, "{ratio}");
    }

    #[test]
    fn a_triangle_is_not_pushed_at_its_doubled_node() {
        let triangle = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 1.0]];
        let controlled = ControlledElement::new((0, 0), [0, 1, 2, 2], [1.0; 4], triangle, 0.1);
        assert_eq!(controlled.offset.map(|o| o > 0.0), [true, true, false, false]);
    }
}
