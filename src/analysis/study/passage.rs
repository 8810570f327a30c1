//! Passage of a projectile through a meshed target: how a shot ends whose run records no event, from the positions and
//! velocities of all pieces at the end of the run.

use super::shot::{CREEP, ShotEnd};
use crate::constraint::of_kind;
use crate::constraint::tie::TiedNodes;
use crate::element::parts::PartTotals;
use crate::kernel::disjoint_sets::DisjointSets;
use crate::plan::{Plan, State};
use crate::state::dofs::Dof;

/// Fraction of the largest initial velocity above which a body belongs to the projectile.
const FAST: f64 = 0.5;
/// Smallest fraction of the initial mass of its body, or of all bodies of projectile or target, of a piece that counts.
const HEAVY: f64 = 0.1;
/// Fraction of the mass of a piece that must be beyond the target.
const PASSED: f64 = 0.9;
/// Relative change of momentum below which the projectile has met no target.
const UNTOUCHED: f64 = 1e-6;

/// Connected active elements and the rigid bodies that share their nodes. Positions and velocities are along the
/// direction of flight.
#[derive(Clone, Debug, Default)]
struct Piece {
    /// Index of the body of which it is a piece: of the piece at the start.
    body: usize,
    mass: f64,
    momentum: f64,
    /// Position and mass of each element and of the last point of each rigid body.
    masses: Vec<(f64, f64)>,
    /// Position of the foremost node of the elements; minus infinity without elements.
    front: f64,
}

impl Piece {
    fn velocity(&self) -> f64 {
        self.momentum / self.mass
    }

    /// Returns whether most of the mass is beyond a position.
    fn is_beyond(&self, position: f64) -> bool {
        let beyond: f64 = self.masses.iter().filter(|(place, _)| *place > position).map(|(_, mass)| mass).sum();
        beyond >= PASSED * self.mass
    }
}

/// End of a shot at a meshed target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PassageEnd {
    pub end: ShotEnd,
    /// Speed of the piece of the projectile that decides it.
    pub speed: f64,
    /// Time until the piece has passed through the target at this speed; infinite if it does not move in a target.
    pub remaining: f64,
}

/// Returns the end of a shot; `None` if the model has no moving projectile, or no meshed target. The projectile consists
/// of the connected bodies with more than half of the largest initial velocity along z, the target of all other meshed
/// bodies. A shot perforates as soon as a heavy piece of the projectile is beyond the largest pieces of all bodies of the
/// target.
pub(super) fn end(plan: &Plan, start: &State, state: &State) -> Option<PassageEnd> {
    let bodies = PieceList::new(plan, start, 1.0);
    let fastest =
        bodies.pieces.iter().map(Piece::velocity).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let (direction, speed) = (fastest.signum(), fastest.abs());
    let is_projectile: Vec<bool> =
        bodies.pieces.iter().map(|body| direction * body.velocity() > FAST * speed).collect();
    let sum = |of_projectile: bool, what: fn(&Piece) -> f64| -> f64 {
        let members = bodies.pieces.iter().zip(&is_projectile).filter(|(_, is)| **is == of_projectile);
        members.map(|(piece, _)| what(piece)).sum()
    };
    let meshed = |piece: &Piece| if piece.front.is_finite() { piece.mass } else { 0.0 };
    let (mass, target) = (sum(true, |piece| piece.mass), sum(false, meshed));
    if speed == 0.0 || mass == 0.0 || target == 0.0 {
        return None;
    }
    let pieces = PieceList::new(plan, state, direction).within(&bodies, start);
    let momentum: f64 = pieces.iter().filter(|p| is_projectile[p.body]).map(|p| p.momentum).sum();
    if (momentum - direction * sum(true, |piece| piece.momentum)).abs() <= UNTOUCHED * mass * speed {
        return Some(PassageEnd { end: ShotEnd::NotMet, speed, remaining: f64::INFINITY });
    }
    let obstacles: Vec<&Piece> = (0..bodies.pieces.len())
        .filter(|body| !is_projectile[*body] && meshed(&bodies.pieces[*body]) >= HEAVY * target)
        .filter_map(|body| {
            let remaining = pieces.iter().filter(|piece| piece.body == body && piece.front.is_finite());
            let largest = remaining.max_by(|a, b| a.mass.total_cmp(&b.mass))?;
            (largest.mass >= HEAVY * bodies.pieces[body].mass).then_some(largest)
        })
        .collect();
    let heavy = pieces.iter().filter(|piece| is_projectile[piece.body] && piece.mass >= HEAVY * mass);
    let ends = heavy.map(|piece| (end_of(piece, &obstacles, speed), piece.mass));
    let rank = |end: ShotEnd| [ShotEnd::Moving, ShotEnd::Perforation].iter().position(|e| *e == end);
    let decisive = ends.max_by(|a, b| rank(a.0.end).cmp(&rank(b.0.end)).then(a.1.total_cmp(&b.1)));
    let consumed = PassageEnd { end: ShotEnd::Consumed, speed: 0.0, remaining: f64::INFINITY };
    Some(decisive.map_or(consumed, |(end, _)| end))
}

/// Returns the end of a piece of the projectile; `speed` is the initial one.
fn end_of(piece: &Piece, obstacles: &[&Piece], speed: f64) -> PassageEnd {
    let velocity = piece.velocity();
    let in_front = || obstacles.iter().filter(|obstacle| !piece.is_beyond(obstacle.front));
    let fastest = in_front().map(|obstacle| obstacle.velocity()).reduce(f64::max);
    let (end, remaining) = match fastest {
        None => (ShotEnd::Perforation, f64::INFINITY),
        Some(fastest) if velocity - fastest > CREEP * speed => {
            let rear = piece.masses.iter().map(|(place, _)| *place).fold(f64::INFINITY, f64::min);
            let front = in_front().map(|obstacle| obstacle.front).fold(f64::NEG_INFINITY, f64::max);
            (ShotEnd::Moving, (front - rear).max(0.0) / (velocity - fastest))
        }
        Some(_) if velocity < -CREEP * speed => (ShotEnd::Ricochet, f64::INFINITY),
        Some(_) => (ShotEnd::Embedded, f64::INFINITY),
    };
    PassageEnd { end, speed: velocity.abs(), remaining }
}

/// What belongs to a piece in any mesh: new meshes change the nodes.
#[derive(Clone, Copy, Debug)]
enum PieceMember {
    Element(usize, usize),
    RigidBody(usize),
}

/// The pieces of a model in a state.
struct PieceList {
    pieces: Vec<Piece>,
    /// Piece of each solver node, then of each rigid body.
    of: Vec<usize>,
    /// A rigid body of each piece as an index of `of`, or one of its elements as group and index.
    members: Vec<PieceMember>,
}

impl PieceList {
    fn new(plan: &Plan, state: &State, direction: f64) -> PieceList {
        let nodes = state.dofs.nodes.len();
        let mut sets = DisjointSets::new(nodes + state.dofs.bodies.len());
        for tie in of_kind::<TiedNodes>(&state.constraints) {
            tie.nodes.iter().for_each(|node| sets.unite(*node, nodes + tie.body));
        }
        let groups = &state.elements.groups;
        let active = || {
            let numbered_elements =
                groups.iter().enumerate().flat_map(|(g, group)| (0..group.len()).map(move |e| (g, e)));
            // Failed elements that stay hold no piece together.
            numbered_elements.filter(|(g, e)| !groups[*g].is_deleted(*e) && !groups[*g].has_failed(*e))
        };
        for (g, e) in active() {
            let members = groups[g].boundary(e);
            members.iter().for_each(|node| sets.unite(members[0] as usize, *node as usize));
        }
        let mut list = PieceList {
            pieces: Vec::new(),
            of: vec![usize::MAX; nodes + state.dofs.bodies.len()],
            members: Vec::new(),
        };
        for (g, e) in active() {
            let members = groups[g].boundary(e);
            let piece = list.piece_at(&mut sets, members[0] as usize, PieceMember::Element(g, e));
            let mut totals = PartTotals::default();
            totals.add(&state.elements, (g, e), &state.dofs.nodes);
            let places = || members.iter().map(|node| direction * state.dofs.nodes[*node as usize].z);
            piece.front = places().fold(piece.front, f64::max);
            piece.mass += totals.mass;
            piece.momentum += direction * totals.momentum;
            piece.masses.push((places().sum::<f64>() / members.iter().count() as f64, totals.mass));
        }
        for (b, body) in state.dofs.bodies.iter().enumerate() {
            let piece = list.piece_at(&mut sets, nodes + b, PieceMember::RigidBody(b));
            piece.mass += body.mass;
            piece.momentum += direction * body.mass * state.dofs.velocity(Dof::Body(b));
            let ends = plan.bodies[b].along_z.map(|z| direction * (z + body.displacement));
            piece.masses.push((ends[0].min(ends[1]), body.mass));
        }
        list
    }

    /// Returns the piece of a node or rigid body, to which a member belongs; creates it if it is new.
    fn piece_at(&mut self, sets: &mut DisjointSets, place: usize, member: PieceMember) -> &mut Piece {
        let root = sets.representative(place);
        if self.of[root] == usize::MAX {
            self.of[root] = self.pieces.len();
            self.members.push(member);
            self.pieces.push(Piece { front: f64::NEG_INFINITY, ..Piece::default() });
        }
        self.of[place] = self.of[root];
        &mut self.pieces[self.of[place]]
    }

    /// Returns the pieces with the index of the body to which each belonged in the state `start`. A body with new meshes is a
    /// whole group of elements.
    fn within(self, bodies: &PieceList, start: &State) -> Vec<Piece> {
        let body = |member: &PieceMember| match *member {
            PieceMember::Element(g, e) => {
                let group = &start.elements.groups[g];
                bodies.of[group.boundary(e.min(group.len() - 1))[0] as usize]
            }
            PieceMember::RigidBody(b) => bodies.of[start.dofs.nodes.len() + b],
        };
        self.pieces
            .into_iter()
            .zip(&self.members)
            .map(|(piece, member)| Piece { body: body(member), ..piece })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(velocity: f64, places: &[f64]) -> Piece {
        let (mass, front) = (places.len() as f64, places.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        Piece { mass, momentum: mass * velocity, masses: places.iter().map(|z| (*z, 1.0)).collect(), front, body: 0 }
    }

    #[test]
    fn pieces_have_passed_only_beyond_all_obstacles() {
        let plate = piece(2.0, &[0.0, 1.0]);
        let loose = piece(50.0, &[4.0, 5.0]);
        let beyond = [2.0, 3.0, 4.0];
        for (velocity, places, obstacles, expected) in [
            (90.0, beyond, &[&plate][..], ShotEnd::Perforation),
            (90.0, [0.5, 2.0, 3.0], &[&plate], ShotEnd::Moving),
            (90.0, beyond, &[&plate, &loose], ShotEnd::Moving),
            (2.5, [0.5, 2.0, 3.0], &[&plate], ShotEnd::Embedded),
            (-0.5, [0.5, 2.0, 3.0], &[&plate], ShotEnd::Embedded),
            (-20.0, [-3.0, -2.0, -1.0], &[&plate], ShotEnd::Ricochet),
            (50.5, beyond, &[&plate, &loose], ShotEnd::Embedded),
            (90.0, [0.5, 2.0, 3.0], &[], ShotEnd::Perforation),
        ] {
            let passage_end = end_of(&piece(velocity, &places), obstacles, 100.0);
            assert_eq!((passage_end.end, passage_end.speed), (expected, velocity.abs()), "{velocity} {places:?}");
        }
    }
}
