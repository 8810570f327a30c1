//! Fields at the end of a run and their L2 norm against an expression or a finer mesh.

use crate::element::group::ElementGroup;
use crate::element::values;
use crate::kernel::quad;
use crate::plan::State;
use crate::platform::PortableMath as _;
use crate::solve::node_value;
use crate::variables::{Variable, VariableComponent, VariablePlace};

/// A nodal or element variable that has a norm. Variables that elements update only for output requests have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldName(VariableComponent);

impl FieldName {
    /// Parses the name of a variable, regardless of case.
    pub(super) fn parse(name: &str) -> Result<FieldName, String> {
        let upper_name = name.trim().to_ascii_uppercase();
        let known = VariableComponent::parse(&upper_name).filter(|p| has_norm(p.variable)).map(FieldName);
        known.ok_or_else(|| {
            let names =
                Variable::ALL.iter().filter(|v| has_norm(**v)).flat_map(|v| v.parts()).map(VariableComponent::label);
            format!("`{}` has no norm; variables with a norm: {}", name.trim(), names.collect::<Vec<_>>().join(", "))
        })
    }
}

fn has_norm(variable: Variable) -> bool {
    match variable {
        Variable::Displacement | Variable::Velocity => true,
        _ => variable.place() == VariablePlace::Point && !variable.row().followed,
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPoint {
    /// Initial coordinates `[r, z]` of the node or of the element centre.
    pub start: [f64; 2],
    pub now: [f64; 2],
    /// Initial volume of the element, or of the node's share of its elements.
    pub weight: f64,
    pub value: f64,
}

/// Values of a variable at all nodes or elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NormField {
    /// Nodes, or the quadrilaterals of the elements.
    pub points: Vec<FieldPoint>,
    pub on_elements: bool,
    /// Initial corner coordinates of the quadrilaterals of all elements.
    pub cells: Vec<[[f64; 2]; 4]>,
    /// Node indices of the corners.
    pub corners: Vec<[u32; 4]>,
    pub time: f64,
}

impl NormField {
    /// Returns the variable at the end of a run.
    pub(super) fn of(state: &State, name: FieldName, time: f64) -> Result<NormField, String> {
        if state.elements.is_empty() {
            return Err("a norm needs deformable elements, and the model has none".into());
        }
        let (mut elements, mut corners, mut cells) = <(Vec<_>, Vec<_>, Vec<_>)>::default();
        for (g, group) in state.elements.groups.iter().enumerate() {
            for e in 0..group.len() {
                for (nodes, places) in cells_of(state, &**group, e) {
                    elements.push((g, e));
                    corners.push(nodes);
                    cells.push(places);
                }
            }
        }
        let FieldName(part) = name;
        let on_elements = part.variable.is_of_elements();
        let points = if on_elements {
            of_elements(state, part, &elements, &corners, &cells)
        } else {
            of_nodes(state, part, &corners, &cells)
        };
        Ok(NormField { points, on_elements, cells, corners, time })
    }

    /// Returns the relative L2 norm of the difference from `exact`: sqrt(sum V (f - exact)^2 / sum V exact^2), with the
    /// initial volumes V. Dimensionless.
    pub(super) fn relative_norm(
        &self,
        mut exact: impl FnMut(&FieldPoint) -> Result<f64, String>,
    ) -> Result<f64, String> {
        let (mut difference, mut size) = (0.0, 0.0);
        // Nodes without elements, such as companion nodes of shell rotations, have no volume.
        for point in self.points.iter().filter(|p| p.weight != 0.0) {
            let expected = exact(point)?;
            difference += point.weight * (point.value - expected) * (point.value - expected);
            size += point.weight * expected * expected;
        }
        if size > 0.0 {
            Ok((difference / size).sqrt())
        } else {
            Err("the reference of the norm is zero everywhere".into())
        }
    }

    /// Returns the relative L2 norm against a finer field, interpolated by shape functions to nodes, or averaged over
    /// the finer elements inside each element.
    pub(super) fn relative_norm_against(&self, fine: &NormField) -> Result<f64, String> {
        let buckets = ElementGrid::new(fine);
        let mut cells = self.cells.iter();
        self.relative_norm(|point| {
            let reference_value = match (self.on_elements, cells.next()) {
                (true, Some(cell)) => buckets.mean_inside(cell, point.start),
                _ => buckets.interpolate(point.start),
            };
            reference_value
                .ok_or_else(|| format!("the finest mesh does not cover r = {}, z = {}", point.start[0], point.start[1]))
        })
    }
}

/// Returns nodes and initial coordinates of the corners of an element's quadrilaterals. A shell element is a
/// quadrilateral of its thickness; its nodes occur on both sides.
fn cells_of(state: &State, group: &dyn ElementGroup, element: usize) -> Vec<([u32; 4], [[f64; 2]; 4])> {
    let nodes = &state.dofs.nodes;
    let start_of = |n: u32| nodes.start[n as usize];
    let Some(thickness) = values::value(group, nodes.as_slice(), element, Variable::Thickness.into()) else {
        return group.cells(element).map(|cell| (cell, cell.map(start_of))).collect();
    };
    let boundary = group.boundary(element);
    let [first, second] = [boundary[0], boundary[1]];
    let (a, b) = (start_of(first), start_of(second));
    let along = [b[0] - a[0], b[1] - a[1]];
    let half = 0.5 * thickness / along[0].portable_hypot(along[1]);
    let offset_point =
        |p: [f64; 2], side: f64| [(p[0] - side * half * along[1]).max(0.0), p[1] + side * half * along[0]];
    vec![(
        [first, second, second, first],
        [offset_point(a, -1.0), offset_point(b, -1.0), offset_point(b, 1.0), offset_point(a, 1.0)],
    )]
}

fn of_elements(
    state: &State,
    part: VariableComponent,
    elements: &[(usize, usize)],
    corners: &[[u32; 4]],
    cells: &[[[f64; 2]; 4]],
) -> Vec<FieldPoint> {
    let (groups, nodes) = (&state.elements.groups, &state.dofs.nodes);
    let element_cells = elements.iter().zip(cells.iter().zip(corners));
    element_cells
        .map(|(&(g, e), (cell, corners))| FieldPoint {
            start: middle(cell),
            now: middle(&corners.map(|n| nodes[n as usize].place())),
            weight: quad::volume(*cell),
            value: values::value(&*groups[g], nodes.as_slice(), e, part).unwrap_or(f64::NAN),
        })
        .collect()
}

fn of_nodes(state: &State, part: VariableComponent, corners: &[[u32; 4]], cells: &[[[f64; 2]; 4]]) -> Vec<FieldPoint> {
    let nodes = &state.dofs.nodes;
    let mut volume = vec![0.0; nodes.len()];
    for (corner, cell) in corners.iter().zip(cells) {
        for (n, share) in corner.iter().zip(quad::corner_masses(*cell, 1.0)) {
            volume[*n as usize] += share;
        }
    }
    let value = |n: usize| node_value(&state.dofs, &state.constraints, n, part);
    let point =
        |n: usize| FieldPoint { start: nodes.start[n], now: nodes[n].place(), weight: volume[n], value: value(n) };
    (0..nodes.len()).map(point).collect()
}

fn middle(corners: &[[f64; 2]; 4]) -> [f64; 2] {
    [0, 1].map(|axis| corners.iter().map(|c| c[axis]).sum::<f64>() / 4.0)
}

/// Spatial grid of the elements of a field, for fast search.
struct ElementGrid<'a> {
    field: &'a NormField,
    low: [f64; 2],
    width: [f64; 2],
    count: usize,
    touching: Vec<Vec<u32>>,
    middles: Vec<Vec<u32>>,
}

impl<'a> ElementGrid<'a> {
    fn new(field: &'a NormField) -> Self {
        let all_corners = || field.cells.iter().flatten();
        let low = [0, 1].map(|axis| all_corners().map(|c| c[axis]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|axis| all_corners().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max));
        let count = (field.cells.len() as f64).sqrt().ceil().clamp(1.0, 1000.0) as usize;
        let width = [0, 1].map(|axis| ((high[axis] - low[axis]) / count as f64).max(f64::MIN_POSITIVE));
        let mut buckets = ElementGrid {
            field,
            low,
            width,
            count,
            touching: vec![vec![]; count * count],
            middles: vec![vec![]; count * count],
        };
        for (e, cell) in field.cells.iter().enumerate() {
            let [from, to] = bounds(cell);
            for bucket in buckets.between(from, to) {
                buckets.touching[bucket].push(e as u32);
            }
            let centre = middle(cell);
            for bucket in buckets.between(centre, centre) {
                buckets.middles[bucket].push(e as u32);
            }
        }
        buckets
    }

    fn between(&self, from: [f64; 2], to: [f64; 2]) -> Vec<usize> {
        let index = |p: [f64; 2], axis: usize| {
            (((p[axis] - self.low[axis]) / self.width[axis]).max(0.0) as usize).min(self.count - 1)
        };
        let rows = index(from, 1)..=index(to, 1);
        rows.flat_map(|j| (index(from, 0)..=index(to, 0)).map(move |i| i + j * self.count)).collect()
    }

    /// Interpolates the value at a point by shape functions of the element that contains it or is closest to it.
    fn interpolate(&self, place: [f64; 2]) -> Option<f64> {
        let mut best: Option<(f64, f64)> = None;
        for bucket in self.between(place, place) {
            for &e in &self.touching[bucket] {
                let (cell, corners) = (&self.field.cells[e as usize], &self.field.corners[e as usize]);
                let Some(local) = local_coordinates(cell, place) else { continue };
                let outside = (local[0].abs() - 1.0).max(local[1].abs() - 1.0);
                if best.is_none_or(|b| outside < b.0) {
                    let value = |k: usize| self.field.points[corners[k] as usize].value;
                    let sum = shapes(local).iter().enumerate().map(|(k, s)| s * value(k)).sum();
                    best = Some((outside, sum));
                }
            }
        }
        // On a curved boundary a coarse node can be slightly outside the finer mesh.
        best.filter(|b| b.0 < 0.5).map(|b| b.1)
    }

    /// Returns the volume-weighted mean over the elements with their centre inside a cell; without such elements, the
    /// value of the element at the centre of the cell.
    fn mean_inside(&self, cell: &[[f64; 2]; 4], place: [f64; 2]) -> Option<f64> {
        let [from, to] = bounds(cell);
        let (mut sum, mut volume) = (0.0, 0.0);
        for bucket in self.between(from, to) {
            for &e in &self.middles[bucket] {
                let point = &self.field.points[e as usize];
                if contains(cell, point.start) {
                    sum += point.weight * point.value;
                    volume += point.weight;
                }
            }
        }
        if volume > 0.0 {
            return Some(sum / volume);
        }
        let around = self.between(place, place).into_iter().flat_map(|b| &self.touching[b]);
        around.map(|&e| e as usize).find(|&e| contains(&self.field.cells[e], place)).map(|e| self.field.points[e].value)
    }
}

fn bounds(cell: &[[f64; 2]; 4]) -> [[f64; 2]; 2] {
    let pick = |fold: fn(f64, f64) -> f64, axis: usize| cell.iter().map(|c| c[axis]).reduce(fold).unwrap_or(0.0);
    [[0, 1].map(|axis| pick(f64::min, axis)), [0, 1].map(|axis| pick(f64::max, axis))]
}

/// Returns whether a point is inside or on the edge of a convex cell with counter-clockwise corners.
fn contains(cell: &[[f64; 2]; 4], place: [f64; 2]) -> bool {
    (0..4).all(|i| {
        let (a, b) = (cell[i], cell[(i + 1) % 4]);
        let area = (b[0] - a[0]) * (place[1] - a[1]) - (b[1] - a[1]) * (place[0] - a[0]);
        let size = (b[0] - a[0]).abs() + (b[1] - a[1]).abs();
        area >= -1e-12 * size * size
    })
}

fn shapes([x, y]: [f64; 2]) -> [f64; 4] {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y))
}

/// Returns the parametric coordinates of a point in an element (-1 to 1 inside) by Newton's method; `None` if it does
/// not converge.
fn local_coordinates(cell: &[[f64; 2]; 4], place: [f64; 2]) -> Option<[f64; 2]> {
    let mut local = [0.0_f64; 2];
    for _ in 0..20 {
        let n = shapes(local);
        let residual = [0, 1].map(|axis| (0..4).map(|k| n[k] * cell[k][axis]).sum::<f64>() - place[axis]);
        let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let along = |axis: usize, by: usize| {
            let other = 1 - by;
            (0..4).map(|k| 0.25 * signs[k][by] * (1.0 + signs[k][other] * local[other]) * cell[k][axis]).sum::<f64>()
        };
        let [[a, b], [c, d]] = [[along(0, 0), along(0, 1)], [along(1, 0), along(1, 1)]];
        let determinant = a * d - b * c;
        let step =
            [(d * residual[0] - b * residual[1]) / determinant, (a * residual[1] - c * residual[0]) / determinant];
        if !(step[0].is_finite() && step[1].is_finite()) {
            return None;
        }
        local = [local[0] - step[0], local[1] - step[1]];
        if step[0].abs() + step[1].abs() < 1e-12 {
            return Some(local);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a unit square of n by n elements with values at nodes or element centres.
    fn square(n: usize, on_elements: bool, law: impl Fn([f64; 2]) -> f64) -> NormField {
        let point = |i: usize, j: usize| [1.0 + i as f64 / n as f64, j as f64 / n as f64];
        let node = |i: usize, j: usize| (i + j * (n + 1)) as u32;
        let mut field = NormField { on_elements, ..NormField::default() };
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            field.cells.push([point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            field.corners.push([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
        }
        let places: Vec<[f64; 2]> = if on_elements {
            field.cells.iter().map(middle).collect()
        } else {
            (0..=n).flat_map(|j| (0..=n).map(move |i| point(i, j))).collect()
        };
        field.points = places.iter().map(|&p| FieldPoint { start: p, now: p, weight: 1.0, value: law(p) }).collect();
        field
    }

    #[test]
    fn linear_fields_are_interpolated_exactly_and_curved_ones_accurately() {
        let linear = |[r, z]: [f64; 2]| 2.0 * r - 3.0 * z;
        for on_elements in [false, true] {
            let (coarse, fine) = (square(3, on_elements, linear), square(12, on_elements, linear));
            let norm = coarse.relative_norm_against(&fine).expect("covered");
            assert!(norm < 1e-12, "{norm:e}");
        }
        let curved = |[r, z]: [f64; 2]| (3.0 * r).sin() * (1.0 + z * z);
        // The fine mesh has a negligible interpolation error; its nodes do not coincide with those of the coarse mesh.
        let norm = square(5, false, curved).relative_norm_against(&square(64, false, curved)).expect("covered");
        assert!(norm < 1e-3, "{norm:e}");
        let wide = NormField { cells: vec![[[9.0, 9.0]; 4]], ..square(2, false, linear) };
        assert!(square(2, false, |_| 0.0).relative_norm(|_| Ok(0.0)).is_err());
        assert!(square(2, false, linear).relative_norm_against(&wide).is_err());
    }
}
