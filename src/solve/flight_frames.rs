//! What a run shows of rigid bodies with six degrees of freedom: numbers at their nodes, and their surface as the facets of the
//! meridian turned around the axis, one cell a station.
//! Never here: which numbers are asked for, files.

use std::collections::HashMap;

use super::run::Run;
use crate::kernel::attitude::{Vector, plus};
use crate::model::Side;
use crate::state::flight::Flight;
use crate::variables::{Part, Variable};

/// A point of such a body: its flight, its node and how far around the axis it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) flight: usize,
    pub(super) node: usize,
    around: f64,
}

/// A number of a point of a body.
fn value(flight: &Flight, place: [f64; 2], around: f64, part: Part) -> f64 {
    let arm = flight.arm(place, around);
    let moved = || plus(flight.place(place, around), -1.0, flight.place_at_start(place, around));
    let turned = || flight.attitude.after(flight.start.attitude.inverse()).vector();
    let component = part.component;
    match part.variable {
        Variable::Coordinate => flight.place(place, around)[component],
        Variable::Displacement => moved()[component],
        Variable::ThirdDisplacement => moved()[2],
        Variable::Velocity => flight.velocity_at(arm)[component],
        Variable::ThirdVelocity => flight.velocity_at(arm)[2],
        Variable::Acceleration => flight.acceleration_at(arm)[component],
        Variable::ThirdAcceleration => flight.acceleration_at(arm)[2],
        Variable::Rotation => turned()[2],
        Variable::OutwardRotation => turned()[component],
        Variable::RotationalVelocity => flight.motion().turning[2],
        Variable::OutwardRotationalVelocity => flight.motion().turning[component],
        Variable::RotationalAcceleration => flight.accelerations()[1][2],
        Variable::OutwardRotationalAcceleration => flight.accelerations()[1][component],
        Variable::Yaw => flight.yaw().to_degrees(),
        Variable::Tilt => flight.tilt().to_degrees(),
        Variable::Reaction | Variable::ReactionMoment => 0.0,
        _ => f64::NAN,
    }
}

/// What frames add for bodies in space.
#[derive(Default)]
pub(super) struct Surfaces {
    /// Points, with where each is and was at the start.
    pub(super) points: Vec<(Point, Vector, Vector)>,
    /// Corners of cells, counted from the first point here.
    pub(super) cells: Vec<Vec<usize>>,
    /// Element of each cell.
    pub(super) elements: Vec<usize>,
}

impl Run<'_> {
    /// A number at a node (of the mesh) of a body in space.
    pub(super) fn flight_value(&self, flight: usize, node: usize, part: Part) -> f64 {
        value(&self.dofs.flights[flight], self.plan.mesh.points[node], 0.0, part)
    }

    /// A number at a point of its surface.
    pub(super) fn point_value(&self, point: &Point, part: Part) -> f64 {
        value(&self.dofs.flights[point.flight], self.plan.mesh.points[point.node], point.around, part)
    }

    /// The surfaces of all bodies in space.
    pub(super) fn surfaces(&self) -> Surfaces {
        let mut all = Surfaces::default();
        (0..self.dofs.flights.len()).for_each(|flight| self.surface(flight, &mut all));
        all
    }

    fn surface(&self, flight: usize, all: &mut Surfaces) {
        let of = &self.dofs.flights[flight];
        let (body, mesh) = (&self.plan.bodies[of.body], &self.plan.mesh);
        let mut rings: HashMap<usize, (usize, usize)> = HashMap::new();
        let stations = of.stations;
        let mut ring = |node: usize, count: usize, points: &mut Vec<(Point, Vector, Vector)>| {
            *rings.entry(node).or_insert_with(|| {
                let (first, place) = (points.len(), mesh.points[node]);
                let count = if place[0] == 0.0 { 1 } else { count };
                for k in 0..count {
                    let around = 2.0 * std::f64::consts::PI * k as f64 / stations as f64;
                    let point = Point { flight, node, around };
                    points.push((point, of.place(place, around), of.place_at_start(place, around)));
                }
                (first, count)
            })
        };
        for (element, ends) in self.faces(of.body) {
            let [(a, many), (b, more)] = ends.map(|n| ring(n, stations, &mut all.points));
            for k in 0..stations {
                let at = |first: usize, count: usize, k: usize| first + k % count;
                let mut cell = vec![at(a, many, k), at(b, more, k), at(b, more, k + 1), at(a, many, k + 1)];
                cell.dedup();
                if cell.first() == cell.last() {
                    cell.pop();
                }
                all.cells.push(cell);
                all.elements.push(element);
            }
        }
        for &node in &body.nodes {
            ring(node, 1, &mut all.points);
        }
    }

    /// The meridian of a body: its facets, and sides of its solids that no other has.
    fn faces(&self, body: usize) -> Vec<(usize, [usize; 2])> {
        let (body, mesh) = (&self.plan.bodies[body], &self.plan.mesh);
        let mut faces = Vec::new();
        let mut solid = false;
        for &e in &body.elements {
            let kind = mesh.elements[e].kind;
            solid |= kind.is_solid();
            if !kind.is_solid() && !kind.is_discrete() {
                faces.extend(mesh.ends(e, Side::Positive).map(|ends| (e, ends)));
            }
        }
        if solid {
            let own = mesh.outside().into_iter().filter(|(e, _)| body.elements.contains(e));
            let ends = own.filter_map(|(e, side)| Some((e, mesh.ends(e, side)?)));
            faces.extend(ends.filter(|(_, ends)| ends.iter().any(|&n| mesh.points[n][0] != 0.0)));
        }
        faces
    }
}

/// What of the values of an element's stations, in the order in which a load tells them, each of its cells shows: one by one, and of
/// an element with more faces than are loaded the mean.
pub(super) fn on_cells(values: &[f64], cells: usize) -> Vec<f64> {
    if values.len() == cells {
        return values.to_vec();
    }
    vec![values.iter().sum::<f64>() / values.len().max(1) as f64; cells]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::attitude::{Attitude, norm};

    #[test]
    fn a_turned_body_shows_the_velocity_of_its_points() {
        let inertia = crate::kernel::attitude::Inertia { axial: 1.0, transverse: 3.0 };
        let attitude = Attitude::turned([0.2, 0.0, -0.4]);
        let turning = [0.3, -2.0, 0.9];
        let momentum = inertia.momentum(attitude.axis(), turning);
        let flight = Flight { mass: 2.0, inertia, attitude, momentum, velocity: [1.0, 2.0, 3.0], ..Flight::default() };
        let place = [0.7, -0.3];
        let dt = 1e-6;
        let mut later = flight.clone();
        later.centre = plus(later.centre, dt, later.velocity);
        later.attitude = inertia.free_motion(attitude, momentum, dt);
        let expected = plus(later.place(place, 0.8), -1.0, flight.place(place, 0.8)).map(|x| x / dt);
        assert!(norm(plus(flight.velocity_at(flight.arm(place, 0.8)), -1.0, expected)) < 1e-5);
        let change = plus(later.velocity_at(later.arm(place, 0.8)), -1.0, flight.velocity_at(flight.arm(place, 0.8)));
        assert!(norm(plus(flight.acceleration_at(flight.arm(place, 0.8)), -1.0 / dt, change)) < 1e-4);
    }
}
