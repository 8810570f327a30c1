//! Mesh files of models.

use revolve::model::Model;
use revolve::output::{FieldArray, OutputFrame};

/// Returns the mesh of a model with labels and sets, to be written as `.vtu`; `*MESH` reads it back to the same model.
/// Labels of different instances are not unique, so a model with instances gets new labels.
pub fn mesh_frame(model: &Model) -> OutputFrame {
    let mesh = &model.mesh;
    let mut frame = OutputFrame {
        points: mesh.points.clone(),
        cells: mesh.elements.iter().map(|e| e.nodes.to_vec()).collect(),
        ..OutputFrame::default()
    };
    let element_names: Vec<&str> = mesh.elements.iter().map(|e| e.name.as_str()).collect();
    let node_names: Vec<&str> = mesh.node_names.iter().map(|name| name.as_str()).collect();
    frame.point_fields.extend(label_field("NODE_LABEL", &node_names));
    frame.cell_fields.extend(label_field("ELEMENT_LABEL", &element_names));
    for (name, set) in &model.node_sets {
        frame.point_fields.push(set_field("NSET_", name, &set.members, mesh.points.len()));
    }
    for (name, set) in &model.element_sets {
        frame.cell_fields.push(set_field("ELSET_", name, &set.members, mesh.elements.len()));
    }
    frame
}

fn scalar(name: String, values: Vec<f64>) -> FieldArray {
    FieldArray { name, components: 1, component_names: Vec::new(), values }
}

fn label_field(name: &str, names: &[&str]) -> Option<FieldArray> {
    let labels: Result<Vec<f64>, _> = names.iter().map(|n| n.parse::<i64>().map(|l| l as f64)).collect();
    labels.ok().map(|values| scalar(name.into(), values))
}

fn set_field(prefix: &str, name: &str, members: &[usize], count: usize) -> FieldArray {
    let mut values = vec![0.0; count];
    for &member in members {
        values[member] = 1.0;
    }
    scalar(format!("{prefix}{name}"), values)
}
