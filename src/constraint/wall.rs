//! A rigid surface of lines and arcs that nodes cannot pass, on a body that is held, moved or moves freely along z.
//! Never here: deck words, contact of deformable surfaces with each other.
//!
//! Kinematic contact: where a node would be behind the surface at the end of an increment, an impulse puts it on the surface
//! (ABAQUS Analysis User's Guide, "Contact constraint enforcement methods in Abaqus/Explicit"). Nothing holds a node that
//! moves away. The impulse acts along the normal where the increment begins and ends on the surface where the increment ends
//! (the constrained central differences of Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327): a node that
//! slides along an arc keeps its speed. What lies behind the surface already is stopped there and not thrown back. Friction
//! takes of the slip along the surface what Coulomb's law allows, and never turns it.
//!
//! On a body that moves freely the impulses J of all nodes and its velocity V follow from each other. As each impulse is a
//! function of V alone, so is what is left of M (V - V*) + sum of J_z = 0: one unknown, whatever the number of nodes and
//! however light the body.

use super::Constraint;
use crate::kernel::profile::Profile;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::dofs::Dofs;
use crate::state::magnitude::Clock;
use crate::state::nodes::Nodes;

/// A surface and the nodes that may meet it.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Its row of the ledger.
    pub id: EffectId,
    /// The body that carries it.
    pub body: usize,
    /// The surface at the start, its front to the left.
    pub profile: Profile,
    /// Coulomb coefficient.
    pub friction: f64,
    /// Nodes, and whether they move freely along r and z.
    pub nodes: Vec<(usize, [bool; 2])>,
    /// Rounding of places: behind the surface by no more counts as on it.
    pub rounding: f64,
    /// Behind the surface by no more a node is stopped; further behind it is not in contact.
    pub overlap: f64,
    /// Force along z on the surface over the increment behind.
    pub force: f64,
    /// Acceleration that a body which moves freely took from it.
    pushed: f64,
    rows: Vec<Row>,
    /// Changes of velocity of each node in this increment, where several passes may change it.
    given: Vec<[f64; 2]>,
}

/// A node near the surface in this increment.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    node: usize,
    /// Which of the surface's nodes it is.
    index: usize,
    segment: usize,
    free: [f64; 2],
    normal: [f64; 2],
    /// Square of the normal along what is free.
    share: f64,
    /// Whether the node can slide both ways along the surface.
    slides: bool,
    /// Gap that the increment is to end with at least.
    target: f64,
    /// Change of velocity along the normal that would bring it there, were the velocity of the body as predicted.
    need: f64,
    /// Velocity without contact.
    velocity: [f64; 2],
    /// Place without contact.
    place: [f64; 2],
    /// Changes of velocity along the normal and the surface.
    change: [f64; 2],
}

impl Row {
    fn tangent(&self) -> [f64; 2] {
        [self.normal[1], -self.normal[0]]
    }

    /// Changes of velocity where the body moves with `faster` above its predicted `velocity`.
    fn solve(&mut self, velocity: f64, faster: f64, friction: f64) {
        let pressed = (self.need + self.normal[1] * faster).max(0.0);
        let mut slowed = 0.0;
        if friction > 0.0 && self.slides && pressed > 0.0 {
            let (t, most) = (self.tangent(), friction * pressed);
            let slip = t[0] * self.velocity[0] + t[1] * (self.velocity[1] - (velocity + faster));
            slowed = (-slip).clamp(-most, most);
        }
        self.change = [pressed, slowed];
    }

    /// Change of velocity by contact.
    fn delta(&self) -> [f64; 2] {
        let [normal, slip] = self.impulses();
        [0, 1].map(|i| self.free[i] * (normal[i] + slip[i]))
    }

    /// Place at the end of an increment.
    fn end(&self, dt: f64) -> [f64; 2] {
        let delta = self.delta();
        [0, 1].map(|i| self.place[i] + dt * delta[i])
    }

    /// Impulse on the node a mass: of the normal, of friction.
    fn impulses(&self) -> [[f64; 2]; 2] {
        let (n, t, [pressed, slowed]) = (self.normal, self.tangent(), self.change);
        let pressed = pressed / self.share;
        [[pressed * n[0], pressed * n[1]], [slowed * t[0], slowed * t[1]]]
    }

    /// Impulse along z on the node a mass, and how it grows with the velocity of the body.
    fn pull(&self, friction: f64) -> [f64; 2] {
        let [normal, slip] = self.impulses();
        if self.change[0] == 0.0 {
            return [0.0, 0.0];
        }
        let (n, t, slowed) = (self.normal[1], self.tangent()[1], self.change[1]);
        let slides = slowed.abs() >= friction * self.change[0];
        let rub = if slides { slowed.signum() * friction * n * t } else { t * t };
        [normal[1] + slip[1], n * n / self.share + if slowed == 0.0 { 0.0 } else { rub }]
    }
}

/// A body over the increment.
#[derive(Clone, Copy, Debug)]
struct Carrier {
    /// Mass where it moves freely; 0 where its motion is prescribed.
    mass: f64,
    velocity: f64,
    /// Displacements at the start and at the end, without contact.
    lift: [f64; 2],
}

/// The smallest part of a normal that must lie along what is free: nodes that are held otherwise would have to be pushed along
/// the surface.
const LEAST_SHARE: f64 = 1e-3;
/// Rounds in which impulses along the normal of the start find the surface where the increment ends.
const ROUNDS: usize = 12;
/// Rounds for the velocity of a free body.
const SEARCH: usize = 60;
/// Passes for nodes that meet a second segment in the same increment.
const PASSES: usize = 4;

impl Wall {
    /// A surface that nodes may meet.
    pub fn new(body: usize, profile: Profile, friction: f64, nodes: Vec<(usize, [bool; 2])>) -> Wall {
        let [low, high] = profile.bounds();
        let extent = low[1].abs().max(high[1].abs()).max(high[0] - low[0]);
        let rounding = 1e-9 * extent;
        let (rows, given) = (Vec::with_capacity(nodes.len()), vec![[0.0; 2]; nodes.len()]);
        Wall {
            id: 0,
            body,
            profile,
            friction,
            nodes,
            rounding,
            overlap: rounding,
            force: 0.0,
            pushed: 0.0,
            rows,
            given,
        }
    }

    /// The nodes that are behind the surface where they come, or could be met by a body that moves freely.
    fn find(&mut self, nodes: &Nodes, carrier: &Carrier, dt: f64) {
        self.rows.clear();
        for (index, &(node, free)) in self.nodes.iter().enumerate() {
            let n = &nodes[node];
            let place = n.place();
            let reach =
                if carrier.mass > 0.0 { dt * (carrier.velocity.abs() + n.v_r.abs() + n.v_z.abs()) } else { 0.0 };
            let end = self.profile.nearest(place, carrier.lift[1]);
            if end.gap >= reach || end.beyond {
                continue;
            }
            let start = [n.r - dt * n.v_r, n.z - dt * n.v_z];
            let Some((segment, target)) = self.met(end.segment, start, carrier.lift[0]) else { continue };
            let met = &self.profile.segments[segment];
            let (normal, gap) = (met.normal(start, carrier.lift[0]), met.gap(place, carrier.lift[1]));
            let moves = free.map(|f| if f { 1.0 } else { 0.0 });
            let share = normal[0] * normal[0] * moves[0] + normal[1] * normal[1] * moves[1];
            if share < LEAST_SHARE {
                continue;
            }
            self.rows.push(Row {
                node,
                index,
                segment,
                free: moves,
                normal,
                share: if free == [true; 2] { 1.0 } else { share },
                slides: free == [true; 2],
                target,
                need: (target - gap) / dt,
                velocity: [n.v_r, n.v_z],
                place,
                change: [0.0; 2],
            });
        }
    }

    /// The segment that a node meets which started at a place, and the gap that it keeps. One that it was behind of although it
    /// was in front of the surface lies around a corner: until it is past, the segment before counts.
    fn met(&self, segment: usize, start: [f64; 2], lift: f64) -> Option<(usize, f64)> {
        let came = self.profile.segments[segment].gap(start, lift);
        if came >= -self.rounding {
            return Some((segment, 0.0));
        }
        let was = self.profile.nearest(start, lift);
        if was.gap >= -self.rounding {
            let own = self.profile.segments[was.segment].gap(start, lift);
            return (own >= -self.rounding).then_some((was.segment, 0.0));
        }
        (came > -self.overlap).then_some((segment, came))
    }

    /// How much faster than predicted the body moves, and the impulses that go with it.
    fn balance(&mut self, nodes: &Nodes, carrier: &Carrier) -> f64 {
        let (friction, velocity) = (self.friction, carrier.velocity);
        let rows = &mut self.rows;
        let mut all = |faster: f64| {
            let (mut sum, mut slope) = (0.0, 0.0);
            for row in rows.iter_mut() {
                row.solve(velocity, faster, friction);
                if carrier.mass > 0.0 {
                    let [pull, grows] = row.pull(friction);
                    sum += nodes.mass[row.node] * pull;
                    slope += nodes.mass[row.node] * grows;
                }
            }
            (sum, slope)
        };
        let (mut sum, mut slope) = all(0.0);
        if carrier.mass == 0.0 || sum == 0.0 {
            return 0.0;
        }
        // Newton's method, kept between velocities that are too low and too high.
        let (mut faster, mut low, mut high) = (0.0, f64::NEG_INFINITY, f64::INFINITY);
        for _ in 0..SEARCH {
            let left = carrier.mass * faster + sum;
            if left > 0.0 {
                high = faster;
            } else {
                low = faster;
            }
            let mut next = faster - left / (carrier.mass + slope.max(0.0));
            if !(next > low && next < high) && low.is_finite() && high.is_finite() {
                next = 0.5 * (low + high);
            }
            if (next - faster).abs() <= 1e-15 * (velocity.abs() + next.abs()) {
                break;
            }
            faster = next;
            (sum, slope) = all(faster);
        }
        // What the body takes is what the nodes gave, to rounding, however near the search came.
        -sum / carrier.mass
    }

    /// Impulses of all rows; along arcs until all end on the surface. Returns how much faster than predicted the body moves.
    fn solve(&mut self, nodes: &Nodes, carrier: &Carrier, dt: f64) -> f64 {
        let mut faster = self.balance(nodes, carrier);
        for _ in 0..ROUNDS {
            let lift = carrier.lift[1] + dt * faster;
            let mut off: f64 = 0.0;
            for row in self.rows.iter_mut().filter(|row| row.change[0] > 0.0) {
                let wrong = row.target - self.profile.segments[row.segment].gap(row.end(dt), lift);
                row.need += wrong / dt;
                off = off.max(wrong.abs());
            }
            if off <= 1e-3 * self.rounding {
                break;
            }
            faster = self.balance(nodes, carrier);
        }
        faster
    }
}

impl Constraint for Wall {
    fn id(&self) -> EffectId {
        self.id
    }

    /// A body whose motion is given holds against what nodes do to it.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        let body = &mut dofs.bodies[self.body];
        if body.prescribed {
            body.reaction -= self.force;
        }
    }

    /// Puts nodes that passed the surface in the increment back on it. What the impulse J does on a node is J times the mean of
    /// its velocities before and after, and so on the body that takes it. Where the motion of the body is given its share is
    /// work of that motion; what the two do not share is lost, as in the impact of masses that do not rebound.
    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        self.force = 0.0;
        self.given.fill([0.0; 2]);
        let (mut pass, mut taken) = (0, 0.0);
        while pass < PASSES && self.meet(dofs, dt, pass > 0, &mut taken) {
            pass += 1;
        }
        let body = &mut dofs.bodies[self.body];
        body.contact -= self.pushed;
        self.pushed = taken / dofs.nodes.half;
        body.contact += self.pushed;
    }

    fn moves_nodes(&self) -> bool {
        true
    }

    fn bytes(&self) -> usize {
        let nodes = size_of::<(usize, [bool; 2])>() * self.nodes.capacity();
        nodes + size_of::<Row>() * self.rows.capacity() + size_of::<[f64; 2]>() * self.given.capacity()
    }

    fn copy(&self) -> Box<dyn Constraint> {
        let mut copy = self.clone();
        copy.rows = Vec::with_capacity(self.nodes.len());
        Box::new(copy)
    }
}

impl Wall {
    /// One pass; behind the first only if something is left to do. Adds to what a free body has `taken`, as a change of
    /// velocity. Returns whether another segment may have to be met.
    fn meet(&mut self, dofs: &mut Dofs, dt: f64, again: bool, taken: &mut f64) -> bool {
        let Dofs { bodies, nodes, energies } = dofs;
        let half = nodes.half;
        let body = &mut bodies[self.body];
        let mass = if body.prescribed { 0.0 } else { body.mass };
        let lift = [body.before.displacement, body.displacement];
        let carrier = Carrier { mass, velocity: body.velocity_half, lift };
        self.find(nodes, &carrier, dt);
        let least = if again { self.rounding / dt } else { 0.0 };
        if !self.rows.iter().any(|row| row.need > least) {
            return false;
        }
        let faster = self.solve(nodes, &carrier, dt);
        let mut mean = body.velocity_half;
        if mass > 0.0 {
            // Velocities before the increment, and by what surfaces have changed it so far; the acceleration stays that of
            // loads, from which the length of increments follows.
            let before = body.before.velocity - (half - 0.5 * dt) * body.acceleration;
            let so_far = body.velocity_half - before - half * body.acceleration;
            body.velocity_half += faster;
            body.displacement += dt * faster;
            mean = 0.5 * (before + body.velocity_half);
            // Its earlier impulses in this increment act over the new velocity.
            energies.contact -= 0.5 * mass * so_far * faster;
            *taken += faster;
        }
        for row in self.rows.iter().filter(|row| row.change[0] > 0.0) {
            let (weight, delta) = (nodes.mass[row.node], row.delta());
            let before = [0, 1].map(|i| row.velocity[i] - half * nodes.acceleration[row.node][i]);
            let place = self.settled(row, dt, body.displacement);
            let node = &mut nodes[row.node];
            for i in [0, 1] {
                *node.velocity(i) += delta[i];
                *node.coordinate(i) = place[i];
            }
            let moved = [before[0] + node.v_r, before[1] + node.v_z];
            for i in [0, 1] {
                nodes.acceleration[row.node][i] += delta[i] / half;
            }
            let [normal, slip] = row.impulses().map(|j| j.map(|j| weight * j));
            self.force -= (normal[1] + slip[1]) / half;
            let lost = |j: [f64; 2]| j[1] * mean - 0.5 * (j[0] * moved[0] + j[1] * moved[1]);
            energies.contact += lost(normal);
            energies.friction += lost(slip);
            if body.prescribed {
                energies.external += (normal[1] + slip[1]) * mean;
            }
            for i in [0, 1] {
                // What holds a node along an axis does the work that it does not take.
                energies.external -= (1.0 - row.free[i]) * 0.5 * normal[i] * moved[i];
                energies.contact -= 0.5 * weight * self.given[row.index][i] * delta[i];
                self.given[row.index][i] += delta[i];
            }
        }
        self.profile.segments.len() > 1 || mass > 0.0
    }

    /// Where a node is at the end of the increment: on the surface, but for no rounding.
    fn settled(&self, row: &Row, dt: f64, lift: f64) -> [f64; 2] {
        let place = row.end(dt);
        let segment = &self.profile.segments[row.segment];
        let (n, off) = (segment.normal(place, lift), segment.gap(place, lift) - row.target);
        if off.abs() > self.rounding {
            return place;
        }
        [0, 1].map(|i| if row.free[i] == 1.0 { place[i] - n[i] * off } else { place[i] })
    }
}

impl Persist for Wall {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Wall { id: _, body: _, profile: _, friction: _, nodes: _, rounding: _, overlap: _, .. } = self;
        let Wall { force, pushed, rows: _, given: _, .. } = self;
        persist_fields!(archive; force, pushed);
    }
}

#[cfg(test)]
mod tests {
    use super::Wall;
    use crate::constraint::Constraint;
    use crate::kernel::profile::{Profile, Segment};
    use crate::state::dofs::Dofs;
    use crate::state::magnitude::Clock;
    use crate::state::nodes::{Node, Nodes};
    use crate::state::{BodyState, Instant};

    /// Nodes without elements, and one body with a surface.
    struct Scene {
        wall: Wall,
        dofs: Dofs,
        gravity: [f64; 2],
    }

    impl Scene {
        /// A body of a mass, or held where it is `None`; nodes with place, velocity and mass.
        fn new(
            profile: Profile,
            friction: f64,
            body: Option<(f64, f64)>,
            nodes: &[([f64; 2], [f64; 2], f64)],
        ) -> Scene {
            let list = nodes.iter().map(|(p, v, _)| Node { r: p[0], z: p[1], v_r: v[0], v_z: v[1] }).collect();
            let masses = nodes.iter().map(|n| n.2).collect();
            let mut state = BodyState::new(body.map_or(1.0, |b| b.0), body.map_or(0.0, |b| b.1));
            state.velocity_half = state.velocity;
            state.prescribed = body.is_none();
            let mut wall = Wall::new(0, profile, friction, (0..nodes.len()).map(|n| (n, [true; 2])).collect());
            wall.overlap = 1e-3;
            let dofs = Dofs { bodies: vec![state], nodes: Nodes::new(list, masses), ..Dofs::default() };
            Scene { wall, dofs, gravity: [0.0; 2] }
        }

        fn advance(&mut self, dt: f64) {
            let body = &mut self.dofs.bodies[0];
            body.acceleration = 0.0;
            (body.before.displacement, body.before.velocity) = (body.displacement, body.velocity_half);
            body.displacement += dt * body.velocity_half;
            let nodes = &mut self.dofs.nodes;
            for n in 0..nodes.len() {
                nodes.acceleration[n] = self.gravity;
                for axis in [0, 1] {
                    *nodes[n].velocity(axis) += dt * self.gravity[axis];
                    let v = *nodes[n].velocity(axis);
                    *nodes[n].coordinate(axis) += dt * v;
                }
            }
            (nodes.behind, nodes.half) = (dt, dt);
            self.wall.motion(&mut self.dofs, &Clock { now: Instant::default(), told: &[] }, dt);
        }

        fn momentum(&self) -> f64 {
            let nodes = &self.dofs.nodes;
            let sum: f64 = (0..nodes.len()).map(|n| nodes.mass[n] * nodes[n].v_z).sum();
            sum + self.dofs.bodies[0].mass * self.dofs.bodies[0].velocity_half
        }

        fn kinetic(&self) -> f64 {
            let nodes = &self.dofs.nodes;
            let of = |n: usize| nodes.mass[n] * (nodes[n].v_r * nodes[n].v_r + nodes[n].v_z * nodes[n].v_z);
            let body = &self.dofs.bodies[0];
            let own = if body.prescribed { 0.0 } else { body.mass * body.velocity_half * body.velocity_half };
            0.5 * ((0..nodes.len()).map(of).sum::<f64>() + own)
        }
    }

    fn lines(points: &[[f64; 2]]) -> Profile {
        Profile { segments: points.windows(2).map(|w| Segment::Line([w[0], w[1]])).collect() }
    }

    /// A bowl of radius 1 around (2, 1), run through counter-clockwise, so that its inside is the front.
    fn bowl() -> Profile {
        let (c, points) = ([2.0, 1.0], [[1.0, 1.0], [2.0, 0.0], [3.0, 1.0]]);
        Profile { segments: points.windows(2).map(|w| Segment::arc(w[0], w[1], c)).collect() }
    }

    /// Without friction a node that slides along a bowl keeps its speed, to rounding, whatever the increment.
    #[test]
    fn sliding_along_a_bowl_keeps_the_speed() {
        for dt in [0.1_f64, 0.01] {
            // On the arc half an increment past its start, along the chord.
            let (c, s) = (dt.cos(), dt.sin());
            let start = [2.0 - c, 1.0 - s];
            let mut scene = Scene::new(bowl(), 0.0, None, &[(start, [0.0, 0.0], 2.0)]);
            let (angle, speed) = (1.5 * dt, 2.0 * (0.5 * dt).sin() / dt);
            (scene.dofs.nodes[0].v_r, scene.dofs.nodes[0].v_z) = (speed * angle.sin(), -speed * angle.cos());
            for _ in 0..(2.5 / dt) as usize {
                scene.advance(dt);
            }
            let node = scene.dofs.nodes[0];
            let radius = (node.r - 2.0).hypot(node.z - 1.0);
            assert!(node.r > 2.5 && (radius - 1.0).abs() < 1e-12, "{node:?}");
            assert!((scene.kinetic() - speed * speed).abs() < 1e-9, "{} {}", dt, scene.kinetic());
            assert!(scene.dofs.energies.contact.abs() < 1e-9, "{:?}", scene.dofs.energies);
        }
    }

    /// In a bowl under gravity a node swings for ever: it comes back as high as it began, ten times over.
    #[test]
    fn a_node_swings_in_a_bowl_as_a_pendulum() {
        let start = [2.0 + 0.5_f64.sin(), 1.0 - 0.5_f64.cos()];
        let mut scene = Scene::new(bowl(), 0.0, None, &[(start, [0.0; 2], 1.0)]);
        scene.gravity = [0.0, -1.0];
        let (mut crossings, mut highest, mut before, mut time) = (Vec::new(), 0.0_f64, start[0] - 2.0, 0.0);
        while crossings.len() < 20 {
            scene.advance(0.01);
            time += 0.01;
            let node = scene.dofs.nodes[0];
            if (node.r - 2.0) * before < 0.0 {
                crossings.push(time);
                highest = 0.0;
            }
            before = node.r - 2.0;
            highest = highest.max(node.z);
        }
        // Period of a pendulum by the complete elliptic integral: 2 pi (1 + a^2/16 + 11 a^4/3072 + ..) for a = 0.5.
        let period = (crossings[18] - crossings[0]) / 9.0;
        let exact = std::f64::consts::TAU * (1.0 + 0.25 / 16.0 + 11.0 * 0.0625 / 3072.0 + 173.0 * 0.015625 / 737_280.0);
        assert!((period / exact - 1.0).abs() < 1e-3, "{period} {exact}");
        while scene.dofs.nodes[0].v_r.abs() > 6e-3 {
            scene.advance(0.01);
            highest = highest.max(scene.dofs.nodes[0].z);
        }
        assert!((highest - start[1]).abs() < 1e-4, "{highest} {}", start[1]);
    }

    /// Over a convex corner nothing acts; in a concave one what points into the second side is lost and nothing else.
    #[test]
    fn corners_do_not_kick() {
        let down = lines(&[[0.0, 0.0], [1.0, 0.0], [2.0, -1.0]]);
        let mut scene = Scene::new(down, 0.0, None, &[([0.95, 0.0], [1.0, 0.0], 1.0)]);
        (0..20).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        assert!((node.v_r, node.v_z) == (1.0, 0.0) && node.z.abs() < 1e-15, "{node:?}");
        let up = lines(&[[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]]);
        let mut scene = Scene::new(up, 0.0, None, &[([0.955, 0.0], [1.0, 0.0], 1.0)]);
        (0..20).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        assert!((node.v_r - 0.5).abs() < 1e-9 && (node.v_z - 0.5).abs() < 1e-9, "{node:?}");
        let lost = scene.dofs.energies.contact;
        assert!((lost - 0.25).abs() < 1e-9 && (lost + scene.kinetic() - 0.5).abs() < 1e-12, "{lost}");
    }

    /// A slope of 45 degrees under gravity, friction 0.3: (1 - 0.3)/sqrt 2 along it, and what is lost is friction.
    #[test]
    fn sliding_down_a_slope_is_slowed_by_friction() {
        let slope = lines(&[[0.0, 10.0], [10.0, 0.0]]);
        let mut scene = Scene::new(slope, 0.3, None, &[([1.0, 9.0], [0.0; 2], 2.0)]);
        scene.gravity = [0.0, -1.0];
        let steps = 400;
        (0..steps).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        let (along, exact) = (node.v_r.hypot(node.v_z), 0.7 / 2.0_f64.sqrt() * 0.01 * f64::from(steps));
        assert!((along / exact - 1.0).abs() < 1e-9, "{along} {exact}");
        let work = 2.0 * (9.0 - node.z);
        let lost = scene.dofs.energies.friction;
        assert!((scene.kinetic() + lost - work).abs() < 0.01 * work, "{lost} {work}");
        assert!(scene.dofs.energies.contact.abs() < 1e-9);
        // It sticks where friction is enough.
        let slope = lines(&[[0.0, 10.0], [10.0, 0.0]]);
        let mut scene = Scene::new(slope, 1.1, None, &[([1.0, 9.0], [0.0; 2], 2.0)]);
        scene.gravity = [0.0, -1.0];
        (0..steps).for_each(|_| scene.advance(0.01));
        assert!((scene.dofs.nodes[0].r - 1.0).abs() < 1e-12);
    }

    /// Bodies from a million times lighter to a thousand times heavier than the nodes they meet: all that touches moves on
    /// together, momentum is kept to rounding and energy only lost.
    #[test]
    fn free_bodies_keep_momentum_however_light() {
        let punch = || {
            let c = [0.0, 2.0];
            Profile { segments: vec![Segment::arc([0.0, 1.0], [1.0, 2.0], c).reversed()] }
        };
        for mass in [1e-6, 1e-3, 1.0, 1e3] {
            for friction in [0.0, 0.3] {
                let nodes: Vec<_> = (0..8).map(|i| ([0.05 + 0.1 * f64::from(i), 0.9999], [0.0; 2], 1.0)).collect();
                let mut scene = Scene::new(punch(), friction, Some((mass, -1.0)), &nodes);
                let (momentum, energy) = (scene.momentum(), scene.kinetic());
                for _ in 0..3000 {
                    scene.advance(1e-4);
                    let lost = scene.dofs.energies.contact + scene.dofs.energies.friction;
                    assert!((scene.kinetic() + lost - energy).abs() < 1e-9 * energy, "{mass} {friction}");
                }
                let now = scene.momentum();
                assert!((now - momentum).abs() < 1e-12 * momentum.abs(), "{mass} {friction}: {now} {momentum}");
                assert!(scene.kinetic() <= energy && scene.dofs.energies.friction >= 0.0);
                for n in 0..8 {
                    let node = scene.dofs.nodes[n];
                    let gap = scene.wall.profile.nearest(node.place(), scene.dofs.bodies[0].displacement).gap;
                    assert!(gap > -1e-9, "{mass} {friction}: {n} {gap}");
                }
            }
        }
    }

    /// A body that falls on one node and carries it along: a perfectly plastic impact.
    #[test]
    fn a_body_takes_a_node_along() {
        let flat = lines(&[[1.0, 0.0], [0.0, 0.0]]);
        let mut scene = Scene::new(flat, 0.0, Some((3.0, -1.0)), &[([0.5, -0.5], [0.0; 2], 1.0)]);
        (0..200).for_each(|_| scene.advance(0.01));
        assert!((scene.dofs.bodies[0].velocity_half + 0.75).abs() < 1e-12);
        assert!((scene.dofs.nodes[0].v_z + 0.75).abs() < 1e-12);
        // Half the reduced mass times the square of the speed.
        assert!((scene.dofs.energies.contact - 0.375).abs() < 1e-12);
    }
}
