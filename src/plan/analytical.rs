//! Pairs of `*CONTACT PAIR` with analytical surfaces: which points, on which side, and what is told of how they start.
//! Never here: the contact itself, pairs of surfaces of elements.

use super::contact_curves::{Around, Found};
use super::{Compiler, State};
use crate::constraint::contact::analytical::Analytical;
use crate::constraint::contact::curve::Curve;
use crate::deck::Diagnostic;
use crate::kernel::interaction::Overclosure;
use crate::kernel::profile::Profile;
use crate::model::{AnalyticalSide, Element, RigidSurface, Sides, SurfaceContact};

/// Part of the smaller of both surfaces by which nodes may begin behind the surface: chords of a mesh, digits of a deck.
const OVERLAP: f64 = 1e-3;

/// How nodes lie to a surface at the start.
#[derive(Debug, Default)]
struct Start {
    /// How far the one furthest behind is behind, and the one furthest in front in front.
    behind: f64,
    front: f64,
    /// How many are behind.
    count: usize,
}

impl Start {
    fn new(profile: &Profile, places: &[[f64; 2]], rounding: f64) -> Start {
        let mut start = Start::default();
        for &place in places {
            let gap = profile.nearest(place, 0.0).gap;
            (start.behind, start.front) = (start.behind.max(-gap), start.front.max(gap));
            start.count += usize::from(gap < -rounding);
        }
        start
    }
}

/// Length of the box around points.
fn extent(points: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let all = points.iter().map(|p| p[axis]);
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    along(0).max(along(1))
}

/// What the ledger says of friction.
pub(super) fn friction_of(pair: &SurfaceContact) -> String {
    match pair.law.friction.at_rest {
        _ if !pair.law.friction.is_there() => String::new(),
        f64::INFINITY => ", rough".into(),
        coefficient => format!(", friction {coefficient}"),
    }
}

/// A surface that meets an analytical one.
#[derive(Clone, Copy)]
struct Opposite<'a> {
    sides: &'a Sides,
    nodes: &'a [usize],
    pair: &'a SurfaceContact,
}

impl Compiler<'_> {
    /// The curve of a pair with an analytical surface and that surface, with the row of the ledger; `None` where they cannot be in
    /// contact, which is told.
    pub(super) fn analytical(
        &mut self,
        (pair, analytical): (&SurfaceContact, &AnalyticalSide),
        around: &Around<'_>,
        found: &mut Found,
        state: &State,
    ) -> Option<([usize; 2], usize)> {
        let sides = &pair.sides[1 - analytical.side];
        let curve = if sides.faces.is_empty() {
            self.curve_of_nodes(pair, &analytical.nodes, around, found)?
        } else {
            self.curve(pair, 1 - analytical.side, around, found)?
        };
        let opposite = Opposite { sides, nodes: &analytical.nodes, pair };
        match self.analytical_surface(opposite, analytical, around, state) {
            Ok((mut surface, body, count)) => {
                surface.point = found.add_carried(body);
                let gives_way =
                    (pair.penalty.is_some() || pair.law.overclosure != Overclosure::Hard) && !sides.faces.is_empty();
                if gives_way {
                    surface.overlap = surface.overlap.max(found.deepest(curve));
                }
                let friction = friction_of(pair);
                let (set, name) = (&sides.name, &pair.sides[analytical.side].name);
                let kind = if gives_way { "gives way" } else { "kinematic" };
                let (effect, detail) = match surface.profile.height() {
                    Some(z) => {
                        let front = if surface.profile.nearest([0.0, z + 1.0], 0.0).gap > 0.0 { "+z" } else { "-z" };
                        let detail = format!("{set} on {name}, z = {z}, which faces {front}, {kind}{friction}");
                        ("contact with a plane", detail)
                    }
                    None => {
                        let segments = surface.profile.segments.len();
                        ("contact with a surface", format!("{set} on {name}, {segments} segments, {kind}{friction}"))
                    }
                };
                let id = self.cause(pair.span, effect, count, "nodes", detail);
                found.analyticals.push(surface);
                Some(([curve, found.analyticals.len() - 1], id))
            }
            Err(why) => {
                let finding = Diagnostic::error("P021", why).at(pair.span, "this pair");
                self.diagnostics.refuse(finding)
            }
        }
    }

    /// A curve of points without facets.
    fn curve_of_nodes(
        &mut self,
        pair: &SurfaceContact,
        nodes: &[usize],
        around: &Around<'_>,
        found: &mut Found,
    ) -> Option<usize> {
        let mut points = Vec::new();
        for &node in nodes {
            match self.point_of(node, around, found) {
                Ok(point) => points.push(point),
                Err(why) => {
                    return self.diagnostics.refuse(Diagnostic::error("P021", why).at(pair.span, "this pair"));
                }
            }
        }
        points.sort_unstable();
        Some(found.add_points(Curve::of_points(points)))
    }

    /// The surface with its front where nodes are, its body, and how many nodes may meet it.
    fn analytical_surface(
        &mut self,
        opposite: Opposite<'_>,
        side: &AnalyticalSide,
        around: &Around<'_>,
        state: &State,
    ) -> Result<(Analytical, usize, usize), String> {
        let surface: &RigidSurface = &self.model.surfaces.analytical[side.surface];
        let reference =
            surface.reference.ok_or("the analytical surface belongs to no *RIGID BODY, ANALYTICAL SURFACE=")?;
        let body = *self.body_of_node.get(&reference).ok_or("the surface's rigid body is missing")?;
        let mut nodes = Vec::new();
        for &node in opposite.nodes {
            let name = &self.model.mesh.node_names[node];
            let place = self
                .places
                .free_node(node)
                .ok_or(format!("node {name} does not deform, or a rigid body carries it"))?;
            nodes.push(place);
        }
        if surface.profile.height().is_some() {
            nodes.retain(|n| !around.prescribed.contains(&(*n, 1)));
        }
        if nodes.is_empty() {
            return Err("no node of this surface deforms".into());
        }
        let places: Vec<[f64; 2]> = nodes.iter().map(|n| state.dofs.nodes.start[*n]).collect();
        let mut analytical = Analytical::new(surface.profile.clone(), 0);
        let ends = surface.profile.bounds();
        let overlap =
            OVERLAP * [extent(&ends), extent(&places)].into_iter().filter(|e| *e > 0.0).fold(f64::MAX, f64::min);
        let profile = self.facing(opposite, surface, &places, analytical.rounding, overlap)?;
        analytical = Analytical::new(profile, 0);
        analytical.overlap = overlap.max(analytical.rounding);
        Ok((analytical, body, nodes.len()))
    }

    /// The surface with its front where the nodes are, and what is to be said of it.
    fn facing(
        &mut self,
        opposite: Opposite<'_>,
        surface: &RigidSurface,
        places: &[[f64; 2]],
        rounding: f64,
        overlap: f64,
    ) -> Result<Profile, String> {
        let Opposite { sides, pair, .. } = opposite;
        let side = usize::from(pair.sides[0].name == sides.name);
        let (profile, name, set) = (surface.profile.clone(), &pair.sides[side].name, &sides.name);
        let start = Start::new(&profile, places, rounding);
        let way = "its front is to the left of the way from START on";
        let help = "give the points of the surface in the opposite order";
        if start.behind <= rounding {
            if start.front <= rounding && self.looks_away(opposite, &profile) {
                let message = format!("`{name}` faces away from `{}`, which lies on it: nothing will meet it", set);
                let finding = Diagnostic::warning("P110", message).at(surface.span, format!("{way}, as in ABAQUS"));
                self.diagnostics.push(finding.at(pair.span, "this pair").help(help));
            }
            return Ok(profile);
        }
        let away = match sides.faces.is_empty() {
            true => start.behind > overlap,
            false => self.looks_away(opposite, &profile),
        };
        if away && start.front <= rounding.max(overlap) {
            let message = format!("`{name}` faces away from `{}`: contact is taken on the side where that is", set);
            let finding = Diagnostic::warning("P110", message).at(surface.span, format!("{way}; ABAQUS keeps to it"));
            self.diagnostics.push(finding.at(pair.span, "this pair").help(help));
            return Ok(profile.reversed());
        }
        if start.behind <= overlap {
            let (count, behind) = (start.count, start.behind);
            let message = format!("{count} nodes of `{}` begin up to {behind:.3e} behind `{name}`", set);
            let finding = Diagnostic::warning("P111", message).at(pair.span, "they stay there and go no deeper");
            self.diagnostics.push(finding.help("move the nodes onto the surface"));
            return Ok(profile);
        }
        if start.front <= overlap {
            return Err(format!("nodes of this surface begin up to {:.3e} behind the analytical one", start.behind));
        }
        Err("nodes of this surface lie on both sides of the analytical one".into())
    }

    /// Whether what has the nodes of a surface lies behind the analytical one, in the mean.
    fn body_of_nodes_is_behind(&self, nodes: &[usize], profile: &Profile) -> bool {
        let mesh = &self.model.mesh;
        let touches = |e: &&Element| e.nodes.len() > 2 && e.nodes.iter().any(|n| nodes.binary_search(n).is_ok());
        let body = mesh.elements.iter().filter(touches).flat_map(|e| &e.nodes);
        body.map(|&n| profile.nearest(mesh.points[n], 0.0).gap).sum::<f64>() < 0.0
    }

    /// Whether the faces of a surface look the same way as the analytical one: those of them that are nearest to it.
    fn looks_away(&self, Opposite { sides, nodes, .. }: Opposite<'_>, profile: &Profile) -> bool {
        let mesh = &self.model.mesh;
        let points = &mesh.points;
        if sides.faces.is_empty() {
            return self.body_of_nodes_is_behind(nodes, profile);
        }
        let face = |f: &[usize; 2]| {
            let [a, b] = f.map(|n| points[n]);
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let near = profile.nearest(middle, 0.0);
            let n = profile.segments[near.segment].normal(middle, 0.0);
            (near.gap.abs(), n[0] * (b[1] - a[1]) - n[1] * (b[0] - a[0]), libm::hypot(b[0] - a[0], b[1] - a[1]))
        };
        let faces: Vec<[usize; 2]> = sides.faces.iter().filter_map(|&(e, side)| mesh.ends(e, side)).collect();
        let least = faces.iter().map(|f| face(f).0).fold(f64::INFINITY, f64::min);
        let near = faces.iter().map(face).filter(|(gap, _, length)| *gap <= least + 0.5 * length);
        near.map(|f| f.1).sum::<f64>() > 0.0
    }
}
