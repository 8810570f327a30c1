//! Output of rigid bodies with six degrees of freedom: values at their nodes, and their surfaces. A surface consists of
//! the meridian facets turned around the axis, with one cell for each facet and station.

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::collections::HashMap;

use super::run_state::RunState;
use crate::kernel::attitude::SpatialVector;
use crate::model::ElementSide;
use crate::plan::Plan;
use crate::state::BodyState;
use crate::variables::{Variable, VariableComponent};

/// A point on the surface of a body with six degrees of freedom: the body, its node and the angle around the axis in
/// radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpatialPoint {
    pub(super) body: usize,
    pub(super) node: usize,
    around: f64,
}

/// Returns the value of a variable at a point of a body with six degrees of freedom; `None` for other bodies.
fn value(body: &BodyState, place: [f64; 2], around: f64, part: VariableComponent) -> Option<f64> {
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

/// A point with its current and initial coordinates.
pub(super) struct SurfacePoint {
    pub(super) point: SpatialPoint,
    pub(super) place: SpatialVector,
    pub(super) start: SpatialVector,
}

/// Points and cells of a frame for bodies with six degrees of freedom.
#[derive(Default)]
pub(super) struct SpatialSurfaces {
    pub(super) points: Vec<SurfacePoint>,
    /// Corners of the cells, as indices of `points`.
    pub(super) cells: Vec<Vec<usize>>,
    /// Element of each cell.
    pub(super) elements: Vec<usize>,
}

/// Returns the value of a variable at a node of the mesh; `None` if the body does not have six degrees of freedom.
pub(super) fn value_in_space(run: &RunState<'_>, body: usize, node: usize, part: VariableComponent) -> Option<f64> {
    value(&run.state.dofs.bodies[body], run.plan.mesh.points[node], 0.0, part)
}

pub(super) fn point_value(run: &RunState<'_>, point: &SpatialPoint, part: VariableComponent) -> f64 {
    value(&run.state.dofs.bodies[point.body], run.plan.mesh.points[point.node], point.around, part).unwrap_or(f64::NAN)
}

/// Returns the surfaces of all bodies with six degrees of freedom.
pub(super) fn surfaces(run: &RunState<'_>) -> SpatialSurfaces {
    let mut surfaces = SpatialSurfaces::default();
    (0..run.state.dofs.bodies.len()).for_each(|body| add_surface(run, body, &mut surfaces));
    surfaces
}

fn add_surface(run: &RunState<'_>, index: usize, all: &mut SpatialSurfaces) {
    let motion_of_body = &run.state.dofs.bodies[index];
    let (body, mesh) = (&run.plan.bodies[index], &run.plan.mesh);
    let Some(stations) = motion_of_body.stations() else { return };
    let mut rings: HashMap<usize, (usize, usize)> = HashMap::new();
    let mut ring = |node: usize, count: usize, points: &mut Vec<SurfacePoint>| {
        *rings.entry(node).or_insert_with(|| {
            let (first, meridian_point) = (points.len(), mesh.points[node]);
            let count = if meridian_point[0] == 0.0 { 1 } else { count };
            for k in 0..count {
                let around = 2.0 * std::f64::consts::PI * k as f64 / stations as f64;
                let Some(motion) = motion_of_body.point_motion(meridian_point, around) else { continue };
                let start = inline_from_fn(|i| motion.place[i] - motion.displacement[i]);
                let point = SpatialPoint { body: index, node, around };
                points.push(SurfacePoint { point, place: motion.place, start });
            }
            (first, count)
        })
    };
    for (element, ends) in faces(run.plan, index) {
        let [(a, many), (b, more)] = ends.inline_map(|n| ring(n, stations, &mut all.points));
        for k in 0..stations {
            let point_of_ring = |first: usize, count: usize, k: usize| first + k % count;
            let mut cell = vec![
                point_of_ring(a, many, k),
                point_of_ring(b, more, k),
                point_of_ring(b, more, k + 1),
                point_of_ring(a, many, k + 1),
            ];
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

/// Returns the meridian of a body: its facets, and the element sides of its solids that no other element shares.
fn faces(plan: &Plan, body: usize) -> Vec<(usize, [usize; 2])> {
    let (body, mesh) = (&plan.bodies[body], &plan.mesh);
    let mut faces = Vec::new();
    let mut solid = false;
    for &e in &body.elements {
        let kind = mesh.elements[e].kind;
        solid |= kind.is_solid();
        if !kind.is_solid() && !kind.is_discrete() {
            faces.extend(mesh.side_nodes(e, ElementSide::Positive).map(|ends| (e, ends)));
        }
    }
    if solid {
        let exposed_sides = mesh.exterior_faces().into_iter().filter(|(e, _)| body.elements.contains(e));
        let ends = exposed_sides.filter_map(|(e, side)| Some((e, mesh.side_nodes(e, side)?)));
        faces.extend(ends.filter(|(_, ends)| ends.iter().any(|&n| mesh.points[n][0] != 0.0)));
    }
    faces
}

/// Distributes the values of an element's stations and their weights, ring by ring in the order of the load, over the
/// element's cells: each cell gets the mean over the rings. If the stations do not form rings, all cells get the mean.
pub(super) fn on_cells(values: &[[f64; 2]], cells: usize) -> Vec<f64> {
    if values.len() == cells {
        return values.iter().map(|v| v[0]).collect();
    }
    let step = if values.len().is_multiple_of(cells) { cells } else { 1 };
    let mean = |cell: usize| {
        let stations = values.iter().skip(cell % step).step_by(step);
        let [sum, weights] = stations.fold([0.0; 2], |[sum, weights], [v, w]| [sum + v * w, weights + w]);
        if weights > 0.0 { sum / weights } else { 0.0 }
    };
    (0..cells).map(mean).collect()
}
