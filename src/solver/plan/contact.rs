//! Contact of a step: its pairs, their interaction laws, penalty stiffness, initial clearances and warnings for initial
//! overlaps.

use std::collections::HashSet;

use super::analytical::friction_of;
use super::cohesive_contact::CohesionList;
use super::contact_curves::{ContactGeometry, CurveContext};
use super::contact_doubts::ContactingCurves;
use super::general_contact::pair_name;
use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::contact::{ContactConstraint, ContactPair, InitialClearance, SurfaceOverlap};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{GapHeat, InteractionLaw, PressureOverclosure};
use crate::model::{AnalyticalSide, GeneralContact, SideSelection, SurfaceContact};

/// Initial overlaps up to this fraction of a facet are accepted without a warning: meshes of matching curved surfaces
/// overlap.
const FIT: f64 = 0.05;
/// Default search distance of clearances, as a fraction of the facet length (ABAQUS Keywords Reference Guide, *CONTACT
/// CLEARANCE: approximately one-tenth of the element size).
const SEARCHED: f64 = 0.1;

impl Compiler<'_> {
    /// Creates the contact constraint of a step.
    pub(super) fn contact(
        &mut self,
        step: usize,
        prescribed: &HashSet<(usize, usize)>,
        state: &State,
    ) -> Option<Box<dyn Constraint>> {
        let (mut found, mut pairs, mut laws) = (ContactGeometry::default(), Vec::new(), Vec::<InteractionLaw>::new());
        let mut springs: Vec<InteractionLaw> = Vec::new();
        let (mut spans, mut cohesion) = (Vec::new(), CohesionList::default());
        let all = self.pairs[step].clone();
        let is_planned = |pair: &&SurfaceContact| self.spatial_side(pair).is_none() && !self.is_lost(pair);
        let wanted: Vec<&SurfaceContact> = all.iter().filter(is_planned).collect();
        if wanted.is_empty() {
            return None;
        }
        let (equal_motions, mut held) = self.links.equal_motions(prescribed);
        held.extend(prescribed);
        let around = CurveContext {
            prescribed: &held,
            in_equations: &self.links.dofs_of_equations(),
            skin: &self.solid_skin(),
            general: self.model.steps[step].general_contact.as_ref(),
            pairs: &all,
        };
        for contact in wanted {
            let pair = match &contact.analytical {
                Some(side) => self.analytical_pair((contact, side), &around, &mut found, state),
                None => self.pair_of_curves(contact, step, &around, &mut found, state),
            };
            let Some((mut pair, length)) = pair else { continue };
            let other = if pair.analytical.is_some() { None } else { Some(pair.other.unwrap_or(pair.own)) };
            let law = self.law(contact, (pair.own, other), (&mut laws, &mut springs), &found, state);
            let Some([law, of_points]) = law else { continue };
            (pair.law, pair.of_points, pair.springs) = (law, of_points, has_springs(contact));
            let origin = (contact, pairs.len(), &pair);
            let added = self.add_cohesion(origin, (&mut laws, &mut springs), (&found, state), &mut cohesion);
            if added.is_none() {
                continue;
            }
            pair.initial_clearance = initial_clearance(contact, length);
            pair.name = pair_name(contact);
            if state.thermal.as_ref().is_some_and(|t| t.heat.is_some()) {
                self.heat_row(contact);
            }
            pairs.push(pair);
            self.check_damping(contact);
            spans.push((contact, length));
        }
        if pairs.is_empty() {
            return None;
        }
        let ContactGeometry { points, places, curves, analyticals, .. } = found;
        let first = laws.len();
        pairs.iter_mut().filter(|p| p.springs).for_each(|p| p.law += first);
        let (any, with_springs) = (!springs.is_empty(), pairs.iter().map(|p| p.springs).collect::<Vec<bool>>());
        laws.extend(springs);
        let mut contact =
            ContactConstraint::new(points, curves, analyticals, pairs, laws).with_equal_motions(equal_motions);
        if any {
            contact = contact.with_springs(first);
        }
        if let Some(heat) = state.thermal.as_ref().and_then(|t| t.heat.as_ref()) {
            if contact.has_equal_motions() {
                let message = "heat conduction through contact of nodes with equal motion is not supported";
                let finding = Diagnostic::error("P021", message).at(all[0].span, "these nodes follow a reference node");
                return self
                    .diagnostics
                    .refuse(finding.help("make the body rigid, or remove these nodes from the surface"));
            }
            let of_body = |body: usize| {
                let node = *self.places.nodes.get(&self.bodies[body].reference)?;
                heat.temperature(node).is_finite().then_some(node)
            };
            contact = contact.with_heat(|node| heat.temperature(node).is_finite(), of_body);
        }
        contact = cohesion.add_to(contact, first, &with_springs);
        let overlaps = contact.start(&places);
        self.report_cohesion(&cohesion, &contact, step);
        // Pairs with analytical surfaces have been checked when they were created.
        for ((contact, length), overlap) in spans.into_iter().zip(overlaps).filter(|s| s.0.0.analytical.is_none()) {
            self.warn_of_overlap(contact, length, overlap);
        }
        Some(Box::new(contact))
    }

    /// Returns whether a surface of a pair has no element on a new mesh, because all of them have been deleted.
    fn is_lost(&self, pair: &SurfaceContact) -> bool {
        let has_members = match &pair.analytical {
            Some(side) => !side.nodes.is_empty(),
            None => pair.sides.iter().all(|side| !side.faces.is_empty()),
        };
        self.model.surfaces.fronts.is_some() && !has_members
    }

    /// Creates the pair of two curves, or of one curve with itself. Returns it with its facet length; the laws are set
    /// later.
    fn pair_of_curves(
        &mut self,
        contact: &SurfaceContact,
        step: usize,
        around: &CurveContext<'_>,
        found: &mut ContactGeometry,
        state: &State,
    ) -> Option<(ContactPair, f64)> {
        let curves = [0, 1].map(|i| self.curve(contact, i, around, found));
        let [Some(first), Some(second)] = curves else { return None };
        if !found.deforms[first] && !found.deforms[second] {
            let message = "both surfaces of this contact pair are rigid";
            let finding = Diagnostic::error("P021", message).at(contact.span, "no deformable surface");
            return self.diagnostics.refuse(finding.help("at least one surface must belong to a deformable body"));
        }
        let general = around.general.filter(|_| contact.general);
        if general.is_some_and(|g| g.excludes_detached_nodes) {
            [first, second].into_iter().for_each(|curve| found.curves[curve].drop_orphans());
        }
        let curves = self.order_curves(contact, [first, second], found);
        let length = found.lengths[first][0].min(found.lengths[second][0]);
        let id = match general {
            Some(general) => self.general_row(general, around.pairs),
            None => self.contact_row(contact, found, curves[0]),
        };
        let met = ContactingCurves {
            curves: curves.map(|c| &found.curves[c]),
            points: &found.points,
            places: &found.places,
            length: found.lengths[curves[0]][1],
            first_carries: curves[0] == first,
        };
        self.check_pair(contact, step, met, state);
        let mut pair = ContactPair::new(id, self.pair_number(contact), curves, length);
        pair.first = curves[0] == first;
        // Faces of one body meet again and again where it folds or erodes; their impacts do not limit the increment.
        if !contact.is_self_contact() {
            let thickness = curves.map(|curve| self.smallest_thickness(&found.facet_elements[curve]));
            pair.thickness = thickness[0].min(thickness[1]);
        }
        Some((pair, length))
    }

    /// Creates the pair of a curve with an analytical surface.
    fn analytical_pair(
        &mut self,
        (contact, side): (&SurfaceContact, &AnalyticalSide),
        around: &CurveContext<'_>,
        found: &mut ContactGeometry,
        state: &State,
    ) -> Option<(ContactPair, f64)> {
        let ([curve, analytical], id) = self.analytical((contact, side), around, found, state)?;
        if around.general.is_some_and(|g| contact.general && g.excludes_detached_nodes) {
            found.curves[curve].drop_orphans();
        }
        let length = found.lengths[curve][0];
        let mut pair = ContactPair::in_front_of(id, self.pair_number(contact), curve, analytical, length);
        pair.first = side.side == 1;
        pair.thickness = self.smallest_thickness(&found.facet_elements[curve]);
        Some((pair, length))
    }

    /// Returns the indices of the law of a pair, in the list of laws or of penalty springs, and of the law for single
    /// points.
    fn law(
        &mut self,
        contact: &SurfaceContact,
        (own, other): (usize, Option<usize>),
        (laws, springs): (&mut Vec<InteractionLaw>, &mut Vec<InteractionLaw>),
        found: &ContactGeometry,
        state: &State,
    ) -> Option<[usize; 2]> {
        let law = match contact.penalty.filter(|_| has_springs(contact)) {
            None => place_of(laws, contact.law.clone()),
            Some(factor) => {
                let all = self.springs(contact, PENALTY_FACTOR * factor, (own, other), found, state)?;
                springs.extend(all);
                springs.len() - found.curves[own].own.len()
            }
        };
        // Contact of single points has no area for a pressure, so that it is hard contact.
        let hard = InteractionLaw { overclosure: PressureOverclosure::Hard, ..contact.law.clone() };
        Some([law, place_of(laws, hard)])
    }

    fn pair_number(&self, contact: &SurfaceContact) -> usize {
        let name = pair_name(contact);
        self.pair_names.get_index_of(&name).unwrap_or_default()
    }

    fn contact_row(&mut self, contact: &SurfaceContact, found: &ContactGeometry, own: usize) -> usize {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let between = if contact.is_self_contact() { format!("{a} with itself") } else { format!("{a} and {b}") };
        // A pressure-overclosure relationship replaces penalty springs.
        let kind = match (&contact.law.overclosure, contact.penalty) {
            (PressureOverclosure::Hard, Some(factor)) => {
                format!("penalty, {} times the element stiffness", PENALTY_FACTOR * factor)
            }
            (PressureOverclosure::Hard, None) => "hard".into(),
            (PressureOverclosure::Linear(_) | PressureOverclosure::Spring(_), _) => "linear".into(),
            (PressureOverclosure::Exponential(_), _) => "exponential".into(),
            (PressureOverclosure::Table(_), _) => "tabular".into(),
        };
        let friction = friction_of(contact);
        let count = found.curves[own].facets.len();
        let clearance = match contact.clearance {
            Some(clearance) if clearance.gap > 0.0 => format!(", clearance {:e}", clearance.gap),
            _ => String::new(),
        };
        self.ledger_row(contact.span, "contact", count, "facets", format!("{between}, {kind}{friction}{clearance}"))
    }

    /// Returns whether one of the surfaces belongs to a rigid body without temperature.
    fn has_cold_side(&self, contact: &SurfaceContact) -> bool {
        let of_side = |side: &SideSelection| side.faces.iter().find_map(|(e, _)| self.body_of_element.get(e)).copied();
        let reference = |side: &AnalyticalSide| self.model.surfaces.analytical[side.surface].reference;
        let of_surface =
            contact.analytical.as_ref().and_then(reference).and_then(|n| self.body_of_node.get(&n)).copied();
        let heated = self.heated_references();
        let cold = |body: usize| !heated.contains(&self.bodies[body].reference);
        contact.sides.iter().filter_map(of_side).chain(of_surface).any(cold)
    }

    /// Creates the ledger row of heat transfer between two surfaces.
    fn heat_row(&mut self, contact: &SurfaceContact) {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let GapHeat { over_clearance, over_pressure, fraction, to_first } = &contact.law.heat;
        let mut parts = Vec::new();
        if contact.law.friction.is_active() {
            parts.push(format!("{fraction} of the frictional work, {to_first} of this heat to {a}"));
        }
        for (rows, over) in [(over_clearance, "clearance"), (over_pressure, "pressure")] {
            if !rows.is_empty() {
                parts.push(format!("conductance table of {} rows over {over}", rows.len()));
            }
        }
        let conducts = !over_clearance.is_empty() || !over_pressure.is_empty();
        if conducts && self.has_cold_side(contact) {
            let message = "no heat flows through this contact: one of the surfaces is rigid and has no temperature";
            self.diagnostics.push(Diagnostic::warning("P067", message).at(contact.span, "this pair"));
        } else if !parts.is_empty() {
            let detail = format!("{a} and {b}: {}", parts.join(", "));
            self.ledger_row(contact.span, "contact heat", 1, "pair", detail);
        }
    }

    /// Returns the laws of springs of each point of a curve. The stiffness is `factor` times 2 / (sum of the compliances of
    /// both surfaces): for two equal bodies and a factor of 1 the stiffness of one layer of elements.
    pub(super) fn springs(
        &mut self,
        contact: &SurfaceContact,
        factor: f64,
        (own, other): (usize, Option<usize>),
        found: &ContactGeometry,
        state: &State,
    ) -> Option<Vec<InteractionLaw>> {
        let softness = |curve: usize| {
            let of = found.facet_elements[curve].iter().map(|&(e, nodes)| self.facet_compliance(e, nodes, state));
            of.collect::<Option<Vec<f64>>>()
        };
        let others = other.map_or(Some(Vec::new()), softness);
        let (Some(own_ways), Some(others)) = (softness(own).filter(|ways| !ways.is_empty()), others) else {
            let message = "the penalty stiffness cannot be computed for the elements of this pair";
            let finding = Diagnostic::error("P021", message).at(contact.span, "this pair");
            self.diagnostics
                .push(finding.help("give *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR, or remove PENALTY"));
            return None;
        };
        // An analytical surface has no compliance.
        let beside = others.iter().sum::<f64>() / others.len().max(1) as f64;
        let curve = &found.curves[own];
        let stiffness = |index: usize| {
            let around = curve.around_own(index).iter().filter_map(|f| own_ways.get(f.0 as usize));
            let (sum, count) = around.fold((0.0, 0), |(sum, count), way| (sum + way, count + 1));
            // Points that are exposed by element deletion have the mean stiffness of the exposed facets.
            let way = match count {
                0 => own_ways.iter().sum::<f64>() / own_ways.len() as f64,
                _ => sum / f64::from(count),
            };
            factor * 2.0 / (way + beside)
        };
        let law = |index| InteractionLaw {
            overclosure: PressureOverclosure::Spring(stiffness(index)),
            ..contact.law.clone()
        };
        Some((0..curve.own.len()).map(law).collect())
    }

    /// Creates the ledger row of general contact, which lists all surfaces of the contact domain.
    pub(super) fn general_row(&mut self, general: &GeneralContact, pairs: &[SurfaceContact]) -> usize {
        let own = || pairs.iter().filter(|p| p.general);
        let mut names: Vec<String> = Vec::new();
        for pair in own() {
            for (at, side) in pair.sides.iter().enumerate() {
                let is_analytical = pair.analytical.as_ref().is_some_and(|a| a.side == at);
                let name = format!("{}{}", side.name, if is_analytical { " (analytical)" } else { "" });
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        let mut detail = format!("surfaces {}", names.join(", "));
        if general.excludes_detached_nodes {
            detail += "; without nodes of deleted elements";
        }
        self.ledger_row(general.span, "general contact", own().count(), "pairs", detail)
    }

    /// Warns of contact damping that has no effect.
    fn check_damping(&mut self, contact: &SurfaceContact) {
        let is_hard = !contact.law.is_soft() && contact.penalty.is_none();
        if contact.law.damping.is_none() || !is_hard {
            return;
        }
        let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
        let message = format!("*CONTACT DAMPING has no effect on the hard contact of `{a}` and `{b}`");
        let finding =
            Diagnostic::warning("P122", message).at(contact.span, "no overlap, so that there is nothing to damp");
        self.diagnostics.push(finding.help("remove the card, or use PENALTY or a pressure-overclosure relationship"));
    }

    /// Warns of an initial overlap of the surfaces of a pair.
    fn warn_of_overlap(&mut self, contact: &SurfaceContact, length: f64, overlap: Option<SurfaceOverlap>) {
        let Some(SurfaceOverlap { depth, place: [r, z] }) = overlap.filter(|o| o.depth > FIT * length) else { return };
        let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
        let message = format!("`{a}` and `{b}` overlap at the start by up to {depth:.3e}");
        let effect = match !contact.law.is_soft() && contact.penalty.is_none() {
            true => "the overlap is kept and does not grow",
            false => "its pressure acts from the start",
        };
        let label = format!("largest near ({r:.4e}, {z:.4e}); {effect}");
        let finding = Diagnostic::warning("P111", message).at(contact.span, label);
        self.diagnostics
            .push(finding.help("move the bodies apart, or use *CONTACT CLEARANCE or *CONTACT INITIALIZATION DATA"));
    }
}

/// Stiffness of penalty springs over that of one layer of elements. It does not limit the increment.
const PENALTY_FACTOR: f64 = 50.0;

/// Returns whether a pair has penalty springs, which a pressure-overclosure relationship replaces.
fn has_springs(contact: &SurfaceContact) -> bool {
    contact.penalty.is_some() && !contact.law.is_soft()
}

/// Returns the initial clearance of a pair and the range of gaps to which it applies.
fn initial_clearance(contact: &SurfaceContact, length: f64) -> Option<InitialClearance> {
    contact.clearance.map(|clearance| {
        let searched = SEARCHED * length;
        let range = [-clearance.below.unwrap_or(searched), clearance.above.unwrap_or(searched)];
        InitialClearance { gap: clearance.gap, range }
    })
}

/// Returns the index of a law in the list, to which it is added if it is new.
pub(super) fn place_of(laws: &mut Vec<InteractionLaw>, law: InteractionLaw) -> usize {
    laws.iter().position(|l| *l == law).unwrap_or_else(|| {
        laws.push(law);
        laws.len() - 1
    })
}
