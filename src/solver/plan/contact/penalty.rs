//! Stiffness of penalty contact from the underlying elements (ABAQUS Analysis User's Guide, "Contact constraint
//! enforcement methods in Abaqus/Explicit").

use crate::constraint::contact::ContactPair;
use crate::deck::Diagnostic;
use crate::element::group::ElementStiffness;
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::topology::MOST_NODES;
use crate::model::{ElementSide, MaterialId, Model, ShellLayer, SurfaceContact};
use crate::plan::contact::curves::{ContactGeometry, height};
use crate::plan::{Report, StepInput};

/// Stiffness of penalty springs over that of one layer of elements. It does not limit the increment.
pub const PENALTY_FACTOR: f64 = 50.0;

/// Returns the compliance of a facet, length per pressure, from the stiffness matrix of its element, or else its
/// thickness over the longitudinal modulus; 0 for rigid facets. `None` if it cannot be determined.
pub fn facet_compliance(input: StepInput, element: usize, nodes: [usize; 2]) -> Option<f64> {
    let StepInput { scene, state, .. } = input;
    let mesh = &scene.model.mesh;
    let Some(&(group, index)) = scene.places.elements.get(&element) else { return Some(0.0) };
    let mesh_element = &mesh.elements[element];
    let [a, b] = nodes.map(|n| mesh.points[n]);
    let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
    let length = libm::hypot(dr, dz);
    if mesh_element.kind.is_shell() {
        let section = scene.model.shell_sections.iter().find(|s| s.elements.contains(&element))?;
        let compliance =
            |layer: &ShellLayer| Some(layer.thickness / longitudinal_modulus(scene.model, layer.material, element)?);
        return section.layers.iter().map(compliance).sum();
    }
    let places = nodes.map(|n| scene.places.nodes.get(&n).copied());
    let matrix = state.elements.groups[group].stiffness(index, state.dofs.nodes.as_slice());
    let Some(ElementStiffness(matrix)) = matrix else {
        return Some(height(mesh_element, &mesh.points, length) / modulus_of(scene.model, element)?);
    };
    // Stiffness of the element for a displacement of the facet along its normal, per area.
    let (corners, normal) = (state.elements.groups[group].nodes(index), [dz / length, -dr / length]);
    let mut way = [0.0; 2 * MOST_NODES];
    for (i, corner) in corners.iter().enumerate() {
        // The last two corners of a triangle are the same node.
        let again = corners[..i].contains(corner);
        if places.contains(&Some(*corner as usize)) && !again {
            (way[2 * i], way[2 * i + 1]) = (normal[0], normal[1]);
        }
    }
    let size = 2 * corners.len();
    let force: f64 = (0..size).map(|i| way[i] * (0..size).map(|j| matrix[i][j] * way[j]).sum::<f64>()).sum();
    let area = std::f64::consts::PI * (a[0] + b[0]) * length;
    (force > 0.0).then(|| area / force)
}

/// Returns the longitudinal modulus of an element; `None` if it cannot be determined.
pub fn modulus_of(model: &Model, element: usize) -> Option<f64> {
    longitudinal_modulus(model, model.sections.iter().find(|s| s.elements.contains(&element))?.material, element)
}

/// Returns the longitudinal modulus of a material at the start: density times the square of the longitudinal wave speed; of a
/// lamina Young's modulus across the fibres.
fn longitudinal_modulus(model: &Model, material: MaterialId, element: usize) -> Option<f64> {
    let material = &model.materials[material];
    let shear = material.shear_modulus.or(material.elastic.map(|[e, nu]| e / (2.0 * (1.0 + nu)))).unwrap_or(0.0);
    if material.eos.is_some() {
        let temperature = initial_temperature(model, element).map(|t| t - model.settings.absolute_zero);
        return Some(material.bulk_modulus(temperature)? + 4.0 / 3.0 * shear);
    }
    if let Some(lamina) = material.lamina {
        return Some(lamina.young[1]);
    }
    material.elastic.map(|[e, nu]| e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)))
}

/// Returns the mean initial temperature of the nodes of an element; `None` if a node has none.
fn initial_temperature(model: &Model, element: usize) -> Option<f64> {
    let nodes = &model.mesh.elements[element].nodes;
    let of_node = |node: &usize| {
        let conditions = model.initial_conditions.iter().rev();
        conditions.filter(|condition| condition.members.binary_search(node).is_ok()).find_map(|c| c.kind.temperature())
    };
    let temperatures: Vec<f64> = nodes.iter().map(of_node).collect::<Option<_>>()?;
    Some(temperatures.iter().sum::<f64>() / nodes.len() as f64)
}

/// Returns the laws of springs of each point of a curve. The stiffness is `factor` times 2 / (sum of the compliances of
/// both surfaces): for two equal bodies and a factor of 1 the stiffness of one layer of elements. Equation (10.7).
pub fn spring_laws(
    input: StepInput,
    contact: &SurfaceContact,
    factor: f64,
    pair: &ContactPair,
    geometry: &ContactGeometry,
    report: &mut Report,
) -> Option<Vec<InteractionLaw>> {
    let compliances = |curve: usize| {
        let facets = geometry.facet_elements[curve].iter();
        facets.map(|&(e, nodes)| facet_compliance(input, e, nodes)).collect::<Option<Vec<f64>>>()
    };
    // An analytical surface has no compliance.
    let opposite = match pair.analytical {
        Some(_) => Some(Vec::new()),
        None => compliances(pair.other.unwrap_or(pair.secondary)),
    };
    let (Some(facet_compliances), Some(opposite)) =
        (compliances(pair.secondary).filter(|list| !list.is_empty()), opposite)
    else {
        return refuse_springs(contact, report);
    };
    let mean_opposite = opposite.iter().sum::<f64>() / opposite.len().max(1) as f64;
    let curve = &geometry.curves[pair.secondary];
    let stiffness = |index: usize| {
        let around = curve.around_own(index).iter().filter_map(|f| facet_compliances.get(f.0 as usize));
        let (sum, count) = around.fold((0.0, 0), |(sum, count), way| (sum + way, count + 1));
        // Points that are exposed by element deletion have the mean stiffness of the exposed facets.
        let compliance = match count {
            0 => facet_compliances.iter().sum::<f64>() / facet_compliances.len() as f64,
            _ => sum / f64::from(count),
        };
        factor * 2.0 / (compliance + mean_opposite)
    };
    Some((0..curve.points.len()).map(|index| spring_law(contact, stiffness(index))).collect())
}

/// Returns the law of the springs of a facet on an oblique rigid body and a rigid wall, from the material of its
/// element. Equation (10.7).
pub fn rigid_spring_law(
    model: &Model,
    contact: &SurfaceContact,
    factor: f64,
    (element, side): (usize, ElementSide),
    report: &mut Report,
) -> Option<InteractionLaw> {
    let (mesh, solid) = (&model.mesh, &model.mesh.elements[element]);
    let compliance = || {
        let [a, b] = mesh.side_nodes(element, side)?.map(|n| mesh.points[n]);
        let modulus = modulus_of(model, element).filter(|_| solid.kind.is_solid())?;
        Some(height(solid, &mesh.points, libm::hypot(b[0] - a[0], b[1] - a[1])) / modulus)
    };
    match compliance() {
        Some(compliance) => Some(spring_law(contact, PENALTY_FACTOR * factor * 2.0 / compliance)),
        None => refuse_springs(contact, report),
    }
}

fn spring_law(contact: &SurfaceContact, stiffness: f64) -> InteractionLaw {
    InteractionLaw { overclosure: PressureOverclosure::Spring(stiffness), ..contact.law.clone() }
}

fn refuse_springs<T>(contact: &SurfaceContact, report: &mut Report) -> Option<T> {
    let message = "the penalty stiffness cannot be computed for the elements of this pair";
    let finding = Diagnostic::error("P021", message).at(contact.span, "this pair");
    report.refuse(finding.help("give *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR, or remove PENALTY"))
}
