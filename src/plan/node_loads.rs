//! Loads and prescribed motions of a step on deformable nodes and faces.
//! Never here: what acts on rigid bodies; what they do in an increment.

use std::collections::HashSet;
use std::rc::Rc;

use indexmap::IndexMap;

use super::Compiler;
use super::loads::prescribed;
use crate::constraint::motion::Prescribed;
use crate::constraint::node_user_motion::{Asked, NodeMotions};
use crate::element::body::{Given, NodeForce, Solid};
use crate::kernel::amplitude::Track;
use crate::kernel::quad::corner_masses;
use crate::load::cavity::Stack;
use crate::load::faces::{Face, FaceCavity, FacePressure, FaceUser, NodeConcentrated, NodeGravity};
use crate::load::user_body::BodyUser;
use crate::load::user_load::UserLoad;
use crate::model::{Boundary, Load, LoadKind, Side, Sides, Step};
use crate::state::magnitude::Magnitude;
use crate::state::magnitude::Shape;

/// Nodes and axes that are given already.
type Taken = HashSet<(usize, usize)>;

impl Compiler<'_> {
    /// What is prescribed on deformable nodes in a step, and the axis, which holds r by itself.
    pub(super) fn given(&mut self, step: &Step, asking: &mut Vec<NodeMotions>) -> Vec<Given> {
        let (mut given, mut taken) = (Vec::new(), Taken::new());
        for boundary in &step.boundaries {
            if boundary.dof > 2 {
                continue;
            }
            let nodes: Vec<usize> = boundary.nodes.iter().filter_map(|n| self.places.free_node(*n)).collect();
            if nodes.is_empty() {
                continue;
            }
            if boundary.user {
                given.extend(self.given_by_user(boundary, &mut taken, asking));
            } else {
                self.given_of(boundary, &nodes, &mut given, &mut taken);
            }
        }
        self.axis(step, &mut given, &taken);
        given
    }

    fn given_of(&mut self, boundary: &Boundary, nodes: &[usize], given: &mut Vec<Given>, taken: &mut Taken) {
        let (kind, value) = prescribed(boundary);
        let axis = usize::from(boundary.dof) - 1;
        let detail = format!("{}: {kind:?} {value} along {}", boundary.set, ["r", "z"][axis]);
        self.cause(boundary.span, "prescribed motion", nodes.len(), "nodes", detail.to_lowercase());
        let magnitude = self.magnitude(value, boundary.amplitude);
        let free = nodes.iter().filter(|&&node| taken.insert((node, axis)));
        given.extend(free.map(|&node| Given { node, axis, kind, magnitude: magnitude.clone() }));
    }

    fn axis(&mut self, step: &Step, given: &mut Vec<Given>, taken: &Taken) {
        let mesh = &self.model.mesh;
        let on_axis = |n: &usize| mesh.points[*n][0] == 0.0;
        let free = self.places.nodes.keys().filter(|n| on_axis(n)).filter_map(|n| self.places.free_node(*n));
        let nodes: Vec<usize> = free.filter(|i| !taken.contains(&(*i, 0))).collect();
        if nodes.is_empty() {
            return;
        }
        self.cause(step.span, "axis of symmetry", nodes.len(), "nodes", "r = 0 held".into());
        let magnitude = Magnitude { value: 0.0, shape: Shape::Constant };
        let kind = Prescribed::Velocity;
        given.extend(nodes.into_iter().map(|node| Given { node, axis: 0, kind, magnitude: magnitude.clone() }));
    }

    /// The part of a load that acts on deformable bodies.
    pub(super) fn node_force(&mut self, load: &Load, solid: &Solid) -> Option<Box<dyn NodeForce>> {
        match &load.kind {
            LoadKind::Pressure(sides) => {
                let faces = self.faces(sides);
                if faces.is_empty() {
                    return None;
                }
                let detail = format!("on {}, p = {}{}", sides.name, load.magnitude, self.amplitude_name(load));
                self.cause(load.span, "pressure", faces.len(), "faces", detail);
                let magnitude = self.magnitude(load.magnitude, load.amplitude);
                Some(Box::new(FacePressure { faces, magnitude }))
            }
            LoadKind::Concentrated { nodes, dof, .. } => {
                let nodes: Vec<usize> = nodes.iter().filter_map(|n| self.places.free_node(*n)).collect();
                if nodes.is_empty() {
                    return None;
                }
                if *dof > 2 {
                    self.unused(load.span, "*CLOAD", "nodes of a body of revolution move along r and z only");
                    return None;
                }
                let detail = format!("{}{}", load.magnitude, self.amplitude_name(load));
                self.cause(load.span, "concentrated force", nodes.len(), "nodes", detail);
                let magnitude = self.magnitude(load.magnitude, load.amplitude);
                Some(Box::new(NodeConcentrated { nodes, axis: usize::from(*dof) - 1, magnitude }))
            }
            LoadKind::Gravity { elements, direction } => {
                self.node_gravity(load, elements.as_deref(), *direction, solid)
            }
            LoadKind::User { sides, load_type } => {
                let faces = self.faces(sides);
                if faces.is_empty() {
                    return None;
                }
                self.face_user(load, sides, *load_type, faces, solid)
            }
            LoadKind::Cavity { sides, target, friction } => {
                let faces = self.faces(sides);
                if faces.is_empty() {
                    return None;
                }
                let target = &self.model.targets[*target];
                let layers = self.layers(target)?;
                let detail = format!("{} into {}", sides.name, target.name);
                self.cause(load.span, "cavity expansion", faces.len(), "faces", detail);
                self.layer_row(target);
                let stack = Stack::new(target.front, target.direction, &layers);
                Some(Box::new(FaceCavity::new(&faces, stack, *friction)))
            }
            LoadKind::UserBody { elements, set, load_type } => {
                self.node_body_user(load, elements, set, *load_type, solid)
            }
        }
    }

    fn node_gravity(
        &mut self,
        load: &Load,
        elements: Option<&[usize]>,
        direction: [f64; 2],
        solid: &Solid,
    ) -> Option<Box<dyn NodeForce>> {
        let axial = load.magnitude * direction[1];
        if axial == 0.0 {
            self.unused(load.span, "GRAV", "it has no component along z, and the scene is a body of revolution");
            return None;
        }
        let masses: Vec<(usize, f64)> = match elements {
            None => solid.mass.iter().copied().enumerate().filter(|m| m.1 > 0.0).collect(),
            Some(list) => self.masses_of(list),
        };
        if masses.is_empty() {
            return None;
        }
        let detail = format!("a_z = {axial}{}", self.amplitude_name(load));
        self.cause(load.span, "gravity", masses.len(), "nodes", detail);
        let acceleration = self.magnitude(axial, load.amplitude);
        Some(Box::new(NodeGravity { masses, whole: elements.is_none(), acceleration }))
    }

    /// Masses that some elements put on their nodes.
    fn masses_of(&self, elements: &[usize]) -> Vec<(usize, f64)> {
        let mesh = &self.model.mesh;
        let mut masses: IndexMap<usize, f64> = IndexMap::new();
        for section in &self.model.sections {
            let density = self.model.materials[section.material].density.unwrap_or(0.0);
            let own: HashSet<usize> = section.elements.iter().copied().collect();
            for &e in elements.iter().filter(|e| own.contains(*e) && self.places.elements.contains_key(*e)) {
                let corners = mesh.corners(e);
                for (n, mass) in corners.iter().zip(corner_masses(corners.map(|n| mesh.points[n]), density)) {
                    *masses.entry(self.places.nodes[n]).or_default() += mass;
                }
            }
        }
        masses.into_iter().collect()
    }

    fn face_user(
        &mut self,
        load: &Load,
        sides: &Sides,
        load_type: i32,
        faces: Vec<Face>,
        solid: &Solid,
    ) -> Option<Box<dyn NodeForce>> {
        let Some(routine) = self.routines.load.clone() else {
            self.no_routine(load.span, "load", &format!("`{}` asks for a user load (PNU)", sides.name), "vdload");
            return None;
        };
        let detail = format!("on {}{}", sides.name, self.amplitude_name(load));
        let cause = self.cause(load.span, "user load", faces.len(), "faces", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        let load = UserLoad { cause, name: sides.name.to_uppercase(), load_type, inward: true, magnitude, routine };
        Some(Box::new(FaceUser::new(load, &faces, &solid.nodes)))
    }

    /// `BRNU` and `BZNU` on deformable elements.
    fn node_body_user(
        &mut self,
        load: &Load,
        elements: &[usize],
        set: &str,
        load_type: i32,
        solid: &Solid,
    ) -> Option<Box<dyn NodeForce>> {
        let mesh = &self.model.mesh;
        let deform = elements.iter().filter(|e| self.places.elements.contains_key(*e));
        let corners: Vec<[u32; 4]> = deform.map(|&e| mesh.corners(e).map(|n| self.places.nodes[&n] as u32)).collect();
        if corners.is_empty() {
            return None;
        }
        let Some(routine) = self.routines.load.clone() else {
            self.no_routine(load.span, "load", &format!("`{set}` asks for a user load (BRNU, BZNU)"), "vdload");
            return None;
        };
        let axis = if load_type == 1 { "r" } else { "z" };
        let detail = format!("on {set} along {axis}{}", self.amplitude_name(load));
        let cause = self.cause(load.span, "user body force", corners.len(), "points", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        let load = UserLoad { cause, name: set.to_uppercase(), load_type, inward: false, magnitude, routine };
        Some(Box::new(BodyUser::new(load, &corners, &solid.nodes)))
    }

    /// `*BOUNDARY, USER`: each node follows what the routine is asked for once an increment.
    fn given_by_user(&mut self, boundary: &Boundary, taken: &mut Taken, asking: &mut Vec<NodeMotions>) -> Vec<Given> {
        let Some(routine) = self.routines.motion.clone() else {
            let asks = format!("the motion of `{}` is the user's (*BOUNDARY, USER)", boundary.set);
            self.no_routine(boundary.span, "motion", &asks, "vdisp");
            return Vec::new();
        };
        let (kind, _) = prescribed(boundary);
        let axis = usize::from(boundary.dof) - 1;
        let names = &self.model.mesh.node_names;
        let places = boundary.nodes.iter().filter_map(|&n| self.places.nodes.get(&n).map(|&place| (n, place)));
        let free = places.filter(|&(_, place)| taken.insert((place, axis)));
        let asked = |(n, node): (usize, usize)| Asked {
            node,
            number: names[n].parse().unwrap_or(n as i32 + 1),
            track: Rc::new(Track::default()),
            offset: 0.0,
        };
        let nodes: Vec<Asked> = free.map(asked).collect();
        let detail = format!("{}: {kind:?} along {} by the user", boundary.set, ["r", "z"][axis]).to_lowercase();
        self.cause(boundary.span, "prescribed motion", nodes.len(), "nodes", detail);
        let magnitude = |a: &Asked| Magnitude { value: 1.0, shape: Shape::Track(a.track.clone()) };
        let given = nodes.iter().map(|a| Given { node: a.node, axis, kind, magnitude: magnitude(a) }).collect();
        let (set, amplitude) = (boundary.set.to_uppercase(), self.magnitude(1.0, boundary.amplitude));
        asking.push(NodeMotions { set, axis, kind, amplitude, routine, nodes, increment_before: 0.0 });
        given
    }

    /// Sides of deformable elements as pairs of nodes.
    fn faces(&self, sides: &Sides) -> Vec<Face> {
        let face = |&(element, side): &(usize, Side)| {
            self.places.elements.get(&element)?;
            Some(self.model.mesh.ends(element, side)?.map(|n| self.places.nodes[&n]))
        };
        sides.faces.iter().filter_map(face).collect()
    }

    /// Whether a load acts on something rigid, too.
    pub(super) fn acts_on_rigid(&self, load: &Load) -> bool {
        let deforms = |e: &usize| self.places.elements.contains_key(e);
        match &load.kind {
            LoadKind::Concentrated { nodes, .. } => !nodes.iter().all(|n| self.places.has_node(*n)),
            LoadKind::Gravity { elements: None, .. } => !self.bodies.is_empty(),
            LoadKind::Gravity { elements: Some(list), .. } | LoadKind::UserBody { elements: list, .. } => {
                !list.iter().all(deforms)
            }
            LoadKind::Pressure(s) | LoadKind::User { sides: s, .. } | LoadKind::Cavity { sides: s, .. } => {
                s.faces.is_empty() || !s.faces.iter().all(|f| deforms(&f.0))
            }
        }
    }
}
