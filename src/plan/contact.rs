//! Pairs of surfaces in contact: which there are, which surface carries the pressures, their laws, what is told of how they start.
//! Never here: curves of facets, how analytical surfaces lie, the contact itself.

use std::collections::HashSet;

use super::analytical::friction_of;
use super::contact_curves::{Around, Found};
use super::contact_doubts::Met;
use super::general_contact::pair_name;
use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::contact::{Begins, Contact, Overlap, Pair};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{GapHeat, Law, Overclosure};
use crate::model::{AnalyticalSide, GeneralContact, SurfaceContact};

/// Overlaps at the start up to this part of a facet are chords of curved surfaces that fit.
const FIT: f64 = 0.05;
/// Gaps and overlaps up to this part of a facet are taken as the clearance that a card gives (ABAQUS Keywords Reference Guide,
/// *CONTACT CLEARANCE: approximately one-tenth of the element size).
const SEARCHED: f64 = 0.1;

impl Compiler<'_> {
    /// All contact of a step.
    pub(super) fn contact(
        &mut self,
        step: usize,
        prescribed: &HashSet<(usize, usize)>,
        state: &State,
    ) -> Option<Box<dyn Constraint>> {
        let (mut found, mut pairs, mut laws) = (Found::default(), Vec::new(), Vec::<Law>::new());
        let mut springs: Vec<Law> = Vec::new();
        let mut spans = Vec::new();
        let all = self.pairs[step].clone();
        let wanted: Vec<&SurfaceContact> = all.iter().filter(|pair| self.spatial_side(pair).is_none()).collect();
        if wanted.is_empty() {
            return None;
        }
        let around = Around { prescribed, kept: &self.kept.concerned(), skin: &self.solid_skin() };
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
            pair.begins = begins(contact, length);
            if state.thermal.as_ref().is_some_and(|t| t.heat.is_some()) {
                self.heat_row(contact);
            }
            pairs.push(pair);
            spans.push((contact, length));
        }
        if pairs.is_empty() {
            return None;
        }
        let Found { points, places, curves, analyticals, .. } = found;
        let first = laws.len();
        pairs.iter_mut().filter(|p| p.springs).for_each(|p| p.law += first);
        let any = !springs.is_empty();
        laws.extend(springs);
        let mut contact = Contact::new(points, curves, analyticals, pairs, laws);
        if any {
            contact = contact.with_springs(first);
        }
        if let Some(heat) = state.thermal.as_ref().and_then(|t| t.heat.as_ref()) {
            contact = contact.with_heat(|node| heat.temperature(node).is_finite());
        }
        let overlaps = contact.start(&places);
        // How nodes lie to analytical surfaces has been told.
        for ((contact, length), overlap) in spans.into_iter().zip(overlaps).filter(|s| s.0.0.analytical.is_none()) {
            self.tell_start(contact, length, overlap);
        }
        Some(Box::new(contact))
    }

    /// The pair of two curves, or of one with itself, and the length of its facets; its laws are still to come.
    fn pair_of_curves(
        &mut self,
        contact: &SurfaceContact,
        step: usize,
        around: &Around<'_>,
        found: &mut Found,
        state: &State,
    ) -> Option<(Pair, f64)> {
        let curves = [0, 1].map(|i| self.curve(contact, i, around, found));
        let [Some(first), Some(second)] = curves else { return None };
        if !found.deforms[first] && !found.deforms[second] {
            let message = "both surfaces of this pair are rigid";
            let finding = Diagnostic::error("P021", message).at(contact.span, "nothing of it deforms");
            return self.diagnostics.refuse(finding.help("one of them must belong to what deforms"));
        }
        let general = self.model.steps[step].general_contact.as_ref().filter(|_| contact.general);
        if general.is_some_and(|g| g.drops_points) {
            [first, second].into_iter().for_each(|curve| found.curves[curve].drop_orphans());
        }
        let curves = found.order(first, second);
        let length = found.lengths[first][0].min(found.lengths[second][0]);
        let id = match general {
            Some(general) => self.general_row(general, step),
            None => self.contact_row(contact, found, curves[0]),
        };
        let met = Met {
            curves: curves.map(|c| &found.curves[c]),
            points: &found.points,
            places: &found.places,
            length: found.lengths[curves[0]][1],
        };
        self.doubt_pair(contact, step, met, state);
        let mut pair = Pair::new(id, self.pair_number(contact), curves, length);
        pair.first = curves[0] == first;
        Some((pair, length))
    }

    /// The same of a curve with an analytical surface.
    fn analytical_pair(
        &mut self,
        (contact, side): (&SurfaceContact, &AnalyticalSide),
        around: &Around<'_>,
        found: &mut Found,
        state: &State,
    ) -> Option<(Pair, f64)> {
        let ([curve, analytical], id) = self.analytical((contact, side), around, found, state)?;
        let length = found.lengths[curve][0];
        let mut pair = Pair::in_front_of(id, self.pair_number(contact), curve, analytical, length);
        pair.first = side.side == 1;
        Some((pair, length))
    }

    /// The law of a pair of curves, of which the second may be rigid, among all laws or those of penalty springs; and that of points
    /// that meet by themselves.
    fn law(
        &mut self,
        contact: &SurfaceContact,
        (own, other): (usize, Option<usize>),
        (laws, springs): (&mut Vec<Law>, &mut Vec<Law>),
        found: &Found,
        state: &State,
    ) -> Option<[usize; 2]> {
        let law = match contact.penalty.filter(|_| has_springs(contact)) {
            None => place_of(laws, contact.law.clone()),
            Some(factor) => {
                let all = self.springs(contact, factor, (own, other), found, state)?;
                springs.extend(all);
                springs.len() - found.curves[own].own.len()
            }
        };
        // What acts on a point by itself is no pressure: it does not give way.
        let hard = Law { overclosure: Overclosure::Hard, ..contact.law.clone() };
        Some([law, place_of(laws, hard)])
    }

    fn pair_number(&self, contact: &SurfaceContact) -> usize {
        let name = pair_name(contact);
        self.pair_names.iter().position(|n| *n == name).unwrap_or_default()
    }

    fn contact_row(&mut self, contact: &SurfaceContact, found: &Found, own: usize) -> usize {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let between = if contact.is_of_one() { format!("{a} with itself") } else { format!("{a} and {b}") };
        // A pressure-overclosure relationship takes the place of penalty springs.
        let kind = match (&contact.law.overclosure, contact.penalty) {
            (Overclosure::Hard, Some(factor)) => format!("penalty springs {factor} times as stiff as the elements"),
            (Overclosure::Hard, None) => "hard".into(),
            (Overclosure::Linear(_) | Overclosure::Spring(_), _) => "linear".into(),
            (Overclosure::Exponential(_), _) => "exponential".into(),
            (Overclosure::Table(_), _) => "tabular".into(),
        };
        let friction = friction_of(contact);
        let count = found.curves[own].facets.len();
        let clearance = match contact.clearance {
            Some(clearance) if clearance.gap > 0.0 => format!(", clearance {:e}", clearance.gap),
            _ => String::new(),
        };
        self.cause(contact.span, "contact", count, "facets", format!("{between}, {kind}{friction}{clearance}"))
    }

    /// The row of the heat that crosses between two surfaces, where temperatures are solved for.
    fn heat_row(&mut self, contact: &SurfaceContact) {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let GapHeat { over_clearance, over_pressure, fraction, to_first } = &contact.law.heat;
        let mut parts = Vec::new();
        if contact.law.friction.is_there() {
            parts.push(format!("{fraction} of the work of friction, {to_first} of it to {a}"));
        }
        for (rows, over) in [(over_clearance, "clearance"), (over_pressure, "pressure")] {
            if !rows.is_empty() {
                parts.push(format!("conductance over {} rows of {over}", rows.len()));
            }
        }
        if !parts.is_empty() {
            let detail = format!("{a} and {b}: {}", parts.join(", "));
            self.cause(contact.span, "contact heat", 1, "pair", detail);
        }
    }

    /// Laws of the penalty springs of each point of a curve in front of another: twice one over the sum of the ways that both
    /// surfaces give under a unit of pressure, so that of two like bodies springs are as stiff as one layer of elements.
    fn springs(
        &mut self,
        contact: &SurfaceContact,
        factor: f64,
        (own, other): (usize, Option<usize>),
        found: &Found,
        state: &State,
    ) -> Option<Vec<Law>> {
        let softness = |curve: usize| {
            let of = found.behind[curve].iter().map(|&(e, nodes)| self.softness(e, nodes, state));
            of.collect::<Option<Vec<f64>>>()
        };
        let others = other.map_or(Some(Vec::new()), softness);
        let (Some(own_ways), Some(others)) = (softness(own).filter(|ways| !ways.is_empty()), others) else {
            let message = "penalty springs are as stiff as the elements behind them, and that cannot be told of these";
            let finding = Diagnostic::error("P021", message).at(contact.span, "this pair");
            self.diagnostics
                .push(finding.help("give *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR, or leave PENALTY out"));
            return None;
        };
        // An analytical surface does not give.
        let beside = others.iter().sum::<f64>() / others.len().max(1) as f64;
        let curve = &found.curves[own];
        let stiffness = |index: usize| {
            let around = curve.around_own(index).iter().filter_map(|f| own_ways.get(f.0 as usize));
            let (sum, count) = around.fold((0.0, 0), |(sum, count), way| (sum + way, count + 1));
            // Points that come to lie bare have springs as those that do in the mean.
            let way = match count {
                0 => own_ways.iter().sum::<f64>() / own_ways.len() as f64,
                _ => sum / f64::from(count),
            };
            factor * 2.0 / (way + beside)
        };
        let law = |index| Law { overclosure: Overclosure::Spring(stiffness(index)), ..contact.law.clone() };
        Some((0..curve.own.len()).map(law).collect())
    }

    fn general_row(&mut self, general: &GeneralContact, step: usize) -> usize {
        let own: Vec<String> = self.pairs[step].iter().filter(|p| p.general).map(pair_name).collect();
        let mut detail = own.iter().take(6).cloned().collect::<Vec<_>>().join(" ");
        if own.len() > 6 {
            detail += " …";
        }
        if general.drops_points {
            detail += ", without points of deleted elements";
        }
        self.cause(general.span, "general contact", own.len(), "pairs", detail)
    }

    /// Says where the surfaces of a pair lie in each other.
    fn tell_start(&mut self, contact: &SurfaceContact, length: f64, overlap: Option<Overlap>) {
        let Some(Overlap { depth, place: [r, z] }) = overlap.filter(|o| o.depth > FIT * length) else { return };
        let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
        let message = format!("`{a}` and `{b}` lie in each other at the start, up to {depth:.3e} deep");
        let label = format!("deepest near ({r:.4e}, {z:.4e}); the overlap stays and grows no deeper");
        let finding = Diagnostic::warning("P111", message).at(contact.span, label);
        self.diagnostics.push(finding.help("move the bodies apart"));
    }
}

/// Whether penalty springs stand between the surfaces of a pair: a pressure-overclosure relationship takes their place.
fn has_springs(contact: &SurfaceContact) -> bool {
    contact.penalty.is_some() && contact.law.overclosure == Overclosure::Hard
}

/// What gaps of a pair at the start are taken as.
fn begins(contact: &SurfaceContact, length: f64) -> Option<Begins> {
    contact.clearance.map(|clearance| {
        let searched = SEARCHED * length;
        let range = [-clearance.below.unwrap_or(searched), clearance.above.unwrap_or(searched)];
        Begins { gap: clearance.gap, range }
    })
}

/// Where a law is among others; it is added where it is not.
fn place_of(laws: &mut Vec<Law>, law: Law) -> usize {
    laws.iter().position(|l| *l == law).unwrap_or_else(|| {
        laws.push(law);
        laws.len() - 1
    })
}
