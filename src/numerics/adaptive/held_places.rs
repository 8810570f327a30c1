//! Places of the mesh that are prescribed in space, and places from which sweeps start.

use super::smoothing::{BoundaryContact, MeshSmoothing, Surroundings, turn_cosine};
use super::topology::{BoundaryNode, DomainTopology};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;
use crate::state::magnitude::{AmplitudeClock, Magnitude};
use crate::state::nodes::Nodes;

/// Most edges of the boundary along which a change of the mesh moves a node.
const REACH: usize = 8;

/// A motion of the mesh that is prescribed in space (`*ADAPTIVE MESH CONSTRAINT`).
#[derive(Clone, Debug, Memory)]
pub struct MeshMotion {
    /// Nodes and axes: 0 is r, 1 is z.
    pub dofs: Vec<(usize, usize)>,
    /// Whether the magnitude is a velocity; otherwise it is a displacement.
    pub is_velocity: bool,
    pub magnitude: Magnitude,
}

/// Prescribed places of the nodes of a domain.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: places; derived: motions, held, kept, returns)]
#[memory(inside: motions)]
pub(super) struct HeldPlaces {
    /// Motions, with the positions of their nodes in the domain.
    motions: Vec<MeshMotion>,
    /// Whether the place of each node along r and z is prescribed.
    held: Vec<[bool; 2]>,
    /// Whether the place of each node along r and z is prescribed, or its material follows a prescribed motion.
    pub kept: Vec<[bool; 2]>,
    /// Whether sweeps start from the places after the previous change of the mesh.
    returns: bool,
    /// Place of each node along the prescribed axes, and after the previous change; NaN before the first step.
    places: Vec<[f64; 2]>,
}

impl HeldPlaces {
    /// Creates the places from motions of nodes that are given by their index in the solver.
    pub fn new(domain: &DomainTopology, mut motions: Vec<MeshMotion>, returns: bool) -> HeldPlaces {
        let count = domain.nodes.len();
        let mut is_held = vec![[false; 2]; count];
        for motion in &mut motions {
            let position = |(node, axis)| Some((domain.nodes.binary_search(&(node as u32)).ok()?, axis));
            motion.dofs = motion.dofs.iter().copied().filter_map(position).collect();
            motion.dofs.iter().for_each(|(node, axis)| is_held[*node][*axis] = true);
        }
        let size = if returns || !motions.is_empty() { count } else { 0 };
        HeldPlaces { motions, held: is_held, kept: vec![[false; 2]; count], returns, places: vec![[f64::NAN; 2]; size] }
    }

    /// Takes the places of a previous step that continue.
    pub fn continue_from(&mut self, previous: &HeldPlaces) {
        if self.places.len() == previous.places.len() && self.held.len() == previous.held.len() {
            for (n, place) in self.places.iter_mut().enumerate() {
                let (held_now, held_before, from) = (self.held[n], previous.held[n], previous.places[n]);
                *place = [0, 1].inline_map(
                    |axis: usize| if held_now[axis] == held_before[axis] { from[axis] } else { place[axis] },
                );
            }
        }
    }

    /// Begins a step: motions without a previous place start from the present one.
    pub fn begin(&mut self, domain: &DomainTopology, prescribed: &[[bool; 2]], nodes: &Nodes) {
        for (place, n) in self.places.iter_mut().zip(&domain.nodes) {
            let now = nodes[*n as usize].place();
            *place = [0, 1].inline_map(|axis: usize| if place[axis].is_nan() { now[axis] } else { place[axis] });
        }
        for ((kept, prescribed), held) in self.kept.iter_mut().zip(prescribed).zip(&self.held) {
            *kept = [0, 1].inline_map(|axis: usize| prescribed[axis] || held[axis]);
        }
    }

    /// Advances the prescribed places by an increment from the time of the clock on. Equation (18.13).
    pub fn advance(&mut self, clock: &AmplitudeClock<'_>, dt: f64) {
        for MeshMotion { dofs, is_velocity, magnitude } in &self.motions {
            let displacement = if *is_velocity {
                dt * magnitude.at(&clock.later(0.5 * dt))
            } else {
                magnitude.at(&clock.later(dt)) - magnitude.at(clock)
            };
            dofs.iter().for_each(|(node, axis)| self.places[*node][*axis] += displacement);
        }
    }

    /// Returns whether the place of a node is prescribed along an axis.
    pub fn is_held(&self, node: usize) -> bool {
        self.held[node] != [false; 2]
    }

    /// Returns whether sweeps start from the places after the previous change of the mesh.
    pub fn returns(&self) -> bool {
        self.returns
    }

    /// Sets the places from which sweeps start: prescribed ones, and those after the previous change of the mesh. `start` are
    /// the places that the material has reached.
    pub fn place(
        &self,
        domain: &DomainTopology,
        (start, end): (&[[f64; 2]], &mut [[f64; 2]]),
        smoothing: &MeshSmoothing,
        surroundings: &dyn Surroundings,
    ) {
        for (n, aim) in self.places.iter().enumerate() {
            let (held_axes, returns) = (self.held[n], self.returns && smoothing.slides(n));
            if smoothing.is_deleted(n) || !(self.is_held(n) || returns) {
                continue;
            }
            let (counts, least) =
                if self.is_held(n) { (held_axes, -1.0) } else { ([true; 2], smoothing.corner_cosine) };
            end[n] = match domain.boundary_at(n as u32).filter(|b| follows_surface(b, held_axes)) {
                Some(node) => {
                    let surface_place = on_surface(domain, start, node, (*aim, counts), least);
                    in_contact(domain.nodes[n] as usize, surface_place, surroundings)
                }
                None => {
                    [0, 1].inline_map(|axis: usize| if held_axes[axis] || returns { aim[axis] } else { start[n][axis] })
                }
            };
        }
    }

    /// Restores the prescribed coordinates of nodes inside after smoothing.
    pub fn restore(&self, from: &[[f64; 2]], to: &mut [[f64; 2]]) {
        for MeshMotion { dofs, .. } in &self.motions {
            dofs.iter().for_each(|(node, axis)| to[*node][*axis] = from[*node][*axis]);
        }
    }

    /// Remembers the places after a change of the mesh along the axes that are not prescribed.
    pub fn remember(&mut self, end: &[[f64; 2]]) {
        for ((place, end), held) in self.places.iter_mut().zip(end).zip(&self.held) {
            *place = [0, 1].inline_map(|axis: usize| if held[axis] { place[axis] } else { end[axis] });
        }
    }
}

/// Returns whether a node stays on the surface of the material: it is not on an Eulerian boundary across which a place is
/// prescribed.
fn follows_surface(node: &BoundaryNode, held: [bool; 2]) -> bool {
    match node.is_open {
        [false, false] => true,
        [true, true] => held == [false; 2],
        _ => held != [true; 2],
    }
}

/// Returns the place of a node of the boundary, or the closest one on the curved surface that presses on it.
fn in_contact(node: usize, place: [f64; 2], surroundings: &dyn Surroundings) -> [f64; 2] {
    let pressed = surroundings.contact(node) == BoundaryContact::Pressed;
    Some(place).filter(|_| pressed).and_then(|place| surroundings.place_on_surface(node, place)).unwrap_or(place)
}

/// Returns the place on the surface of the material that is nearest to an aim along the axes that count. At the end of an
/// Eulerian boundary the surface does not turn into this boundary; its first edge extends beyond the node. The place is not
/// beyond a node where the surface turns by more than the angle of `corner_cosine`.
fn on_surface(
    domain: &DomainTopology,
    places: &[[f64; 2]],
    node: &BoundaryNode,
    (aim, counts): ([f64; 2], [bool; 2]),
    corner_cosine: f64,
) -> [f64; 2] {
    let counted = |a: [f64; 2], b: [f64; 2]| {
        (0..2).filter(|axis| counts[*axis]).map(|axis| a[axis] * b[axis]).fold(0.0, |sum, x| sum + x)
    };
    let off = |place: [f64; 2]| {
        let offset = [place[0] - aim[0], place[1] - aim[1]];
        counted(offset, offset)
    };
    let own_place = places[node.node as usize];
    let around = [node.before, node.node, node.after].inline_map(|n| places[n as usize]);
    if turn_cosine(around) <= corner_cosine {
        return own_place;
    }
    let (mut best, is_open) = (own_place, node.is_open == [true; 2]);
    for side in (0..2).filter(|side| node.is_open[*side] == is_open) {
        let mut from = node;
        for edge in 0..REACH {
            let to_node = if side == 0 { from.before } else { from.after };
            let [a, b] = [from.node, to_node].inline_map(|n| places[n as usize]);
            let along = [b[0] - a[0], b[1] - a[1]];
            let square = counted(along, along);
            let share = if square > 0.0 { counted([aim[0] - a[0], aim[1] - a[1]], along) / square } else { 0.0 };
            let least = if edge == 0 && node.is_open[1 - side] != is_open { -1.0 } else { 0.0 };
            let within = share.clamp(least, 1.0);
            let mut candidate = [0, 1].inline_map(|axis: usize| a[axis] + within * along[axis]);
            if within == share && counts != [true; 2] {
                let axis = usize::from(counts[1]);
                candidate[axis] = aim[axis];
            }
            if off(candidate) < off(best) {
                best = candidate;
            }
            let next = domain.boundary_at(to_node).filter(|next| next.is_open[side] == is_open);
            let Some(next) = next.filter(|_| share > 1.0) else { break };
            let ends = [next.before, next.node, next.after].inline_map(|n| places[n as usize]);
            if turn_cosine(ends) <= corner_cosine {
                break;
            }
            from = next;
        }
    }
    best
}
