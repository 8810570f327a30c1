//! Output of rigid bodies that move in space: values at their nodes, and their surface as the facets of the meridian turned around
//! the axis, one cell a station.
//! Never here: which numbers are asked for, files.

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::collections::HashMap;

use super::run::Run;
use crate::kernel::attitude::Vector;
use crate::model::Side;
use crate::state::BodyState;
use crate::variables::{Part, Variable};

/// A point of such a body: the body, its node and how far around the axis it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) body: usize,
    pub(super) node: usize,
    around: f64,
}

/// A value at a point of a body that moves in space; `None` of others.
fn value(body: &BodyState, place: [f64; 2], around: f64, part: Part) -> Option<f64> {
    let motion = body.point_motion(place, around)?;
    let component = part.component;
    Some(match part.variable {
        Variable::Coordinate => motion.place[component],
        Variable::Displacement => motion.displacement[component],
        Variable::ThirdDisplacement => motion.displacement[2],
        Variable::Velocity => motion.velocity[component],
        Variable::ThirdVelocity => motion.velocity[2],
        Variable::Acceleration => motion.acceleration[component],
        Variable::ThirdAcceleration => motion.acceleration[2],
        Variable::Rotation => motion.rotation[2],
        Variable::OutwardRotation => motion.rotation[component],
        Variable::RotationalVelocity => motion.rotational_velocity[2],
        Variable::OutwardRotationalVelocity => motion.rotational_velocity[component],
        Variable::RotationalAcceleration => motion.rotational_acceleration[2],
        Variable::OutwardRotationalAcceleration => motion.rotational_acceleration[component],
        Variable::Yaw => motion.yaw.to_degrees(),
        Variable::Tilt => motion.tilt.to_degrees(),
        Variable::Reaction | Variable::ReactionMoment => 0.0,
        _ => f64::NAN,
    })
}

/// What frames add for bodies in space.
#[derive(Default)]
pub(super) struct Surfaces {
    /// Points, with where each is and was at the start.
    pub(super) points: Vec<(Point, Vector, Vector)>,
    /// Corners of cells, counted from the first point here.
    pub(super) cells: Vec<Vec<usize>>,
    pub(super) elements: Vec<usize>,
}

impl Run<'_> {
    /// A value at a node (of the mesh) of a body that moves in space; `None` of others.
    pub(super) fn value_in_space(&self, body: usize, node: usize, part: Part) -> Option<f64> {
        value(&self.state.dofs.bodies[body], self.plan.mesh.points[node], 0.0, part)
    }

    pub(super) fn point_value(&self, point: &Point, part: Part) -> f64 {
        value(&self.state.dofs.bodies[point.body], self.plan.mesh.points[point.node], point.around, part)
            .unwrap_or(f64::NAN)
    }

    /// The surfaces of all bodies that move in space.
    pub(super) fn surfaces(&self) -> Surfaces {
        let mut all = Surfaces::default();
        (0..self.state.dofs.bodies.len()).for_each(|body| self.surface(body, &mut all));
        all
    }

    fn surface(&self, index: usize, all: &mut Surfaces) {
        let of = &self.state.dofs.bodies[index];
        let (body, mesh) = (&self.plan.bodies[index], &self.plan.mesh);
        let Some(stations) = of.stations() else { return };
        let mut rings: HashMap<usize, (usize, usize)> = HashMap::new();
        let mut ring = |node: usize, count: usize, points: &mut Vec<(Point, Vector, Vector)>| {
            *rings.entry(node).or_insert_with(|| {
                let (first, place) = (points.len(), mesh.points[node]);
                let count = if place[0] == 0.0 { 1 } else { count };
                for k in 0..count {
                    let around = 2.0 * std::f64::consts::PI * k as f64 / stations as f64;
                    let Some(motion) = of.point_motion(place, around) else { continue };
                    let start = inline_from_fn(|i| motion.place[i] - motion.displacement[i]);
                    points.push((Point { body: index, node, around }, motion.place, start));
                }
                (first, count)
            })
        };
        for (element, ends) in self.faces(index) {
            let [(a, many), (b, more)] = ends.inline_map(|n| ring(n, stations, &mut all.points));
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
