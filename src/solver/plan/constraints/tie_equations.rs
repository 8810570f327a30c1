//! Equations of `*TIE`: each dependent node follows a weighted mean of nodes of the other surface.

use std::collections::HashSet;

use crate::model::Model;
use crate::plan::constraints::surface_ties::AttachedNode;
use crate::plan::constraints::tie_integration::TiedPair;

/// A node that follows others along r and z.
#[derive(Clone, Debug, PartialEq)]
pub struct TiedNode {
    /// Index of the mesh node.
    pub node: usize,
    /// Element of a facet that the node follows.
    pub element: usize,
    /// Nodes that it follows and their weights, whose sum is 1.
    pub shares: Vec<(usize, f64)>,
    /// The next tied node, if this one is at an end of the common surface.
    pub next: Option<NextNode>,
}

/// The tied node next to one at an end of the common surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextNode {
    pub node: usize,
    /// Area of the node at the end relative to that of this one.
    pub area: f64,
}

/// Formulation of a tie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TieForm {
    /// Equal weighted means over the common surface.
    Integrated,
    /// Each node follows the nearest point of the master surface.
    Nodes,
    /// As `Nodes`, although the tie is surface to surface, because no slave facet is opposite the master surface.
    NothingOpposite,
}

/// The equations of one tie.
#[derive(Clone, Debug)]
pub struct TieEquations {
    pub nodes: Vec<TiedNode>,
    pub form: TieForm,
}

/// Returns the equations of all ties. A node that one tie makes dependent is not dependent in later ties.
pub fn tie_equations(model: &Model, attached: &[Vec<AttachedNode>]) -> Vec<TieEquations> {
    let rigid = nodes_of_rigid_bodies(model);
    let mut taken: HashSet<usize> = HashSet::new();
    let mut equations = Vec::new();
    for (tie, attached) in model.constraints.ties.iter().zip(attached) {
        let pair = TiedPair::new(model, tie, attached);
        // A rigid surface has one motion along z, and all means are equal.
        let follows_body = tie.slave_faces.is_empty() || pair.nodes().any(|n| rigid.contains(&n));
        let integrated = if follows_body { None } else { pair.equations(&taken) };
        let form = match integrated {
            Some(_) => TieForm::Integrated,
            None if follows_body => TieForm::Nodes,
            None => TieForm::NothingOpposite,
        };
        let nodes = integrated.unwrap_or_else(|| node_equations(attached, &taken));
        taken.extend(nodes.iter().map(|n| n.node));
        equations.push(TieEquations { nodes, form });
    }
    equations
}

fn nodes_of_rigid_bodies(model: &Model) -> HashSet<usize> {
    let elements = model.rigid_bodies.iter().flat_map(|body| &body.elements);
    let of_elements = elements.flat_map(|&e| model.mesh.elements[e].nodes.iter());
    let others = model.rigid_bodies.iter().flat_map(|body| body.nodes.iter().chain([&body.reference]));
    of_elements.chain(others).copied().collect()
}

/// Returns the equations in which each node follows the nearest point of the master surface. Equation (11.7).
fn node_equations(attached: &[AttachedNode], taken: &HashSet<usize>) -> Vec<TiedNode> {
    let tied = attached.iter().filter(|a| !a.is_shared && !taken.contains(&a.node));
    tied.map(|a| TiedNode { node: a.node, element: a.element, shares: a.shares.clone(), next: None }).collect()
}
