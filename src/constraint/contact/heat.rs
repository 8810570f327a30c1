//! Heat where surfaces meet: what flows across the gap, and what friction makes of its work.
//! Never here: temperatures over time, impulses.
//!
//! Each point of the own curve takes the mean temperature of both surfaces with the weights that its gap has of their points, and
//! passes conductance times area times their difference from one to the other with the same weights: the matrix K = sum k A c c^T is
//! symmetric, what one surface loses the other gains, and one temperature stays one. Of friction each surface takes its share of the
//! work of the row.

use super::curve::{Carrier, Point};
use super::sweeps::{Row, Rows, Term};
use crate::constraint::HeatExchange;
use crate::kernel::interaction::Law;
use crate::kernel::lists::MemoryUse;
use crate::state::archive::persist_struct;

/// No point.
const NONE: u32 = u32::MAX;

#[derive(Clone, Debug)]
pub(super) struct Crossing {
    /// The node of each point; [`NONE`] where it has no temperature.
    nodes: Vec<u32>,
    /// The point of each degree of freedom, and along which axis it is.
    point_of: Vec<(u32, usize)>,
    /// The point of each key, and whether it is of the first surface of its pair as that was given.
    keys: Vec<(u32, bool)>,
    rows: Vec<Passing>,
    /// Points and their weights: those of each surface sum up to one, the own below, the other above zero.
    terms: Vec<(u32, f64)>,
    /// What each point could at most exchange, heat a time and temperature.
    most: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Passing {
    key: u32,
    terms: [u32; 2],
    /// Conductance times area.
    conducts: f64,
    /// Heat of friction in the increment into both surfaces, the own one first.
    made: [f64; 2],
}

impl Crossing {
    /// Between points, of which those that have a temperature are told by their node, with these degrees of freedom and keys.
    pub(super) fn new(
        (points, dofs_of): (&[Point], &[[u32; 2]]),
        dofs: usize,
        keys: Vec<(u32, bool)>,
        has: impl Fn(usize) -> bool,
    ) -> Crossing {
        let node = |p: &Point| match p.carrier {
            Carrier::Node(n) if has(n) => n as u32,
            _ => NONE,
        };
        let mut point_of = vec![(NONE, 0); dofs];
        for (i, (of, point)) in dofs_of.iter().zip(points).enumerate() {
            if let Carrier::Node(_) = point.carrier {
                of.iter().enumerate().for_each(|(axis, &dof)| point_of[dof as usize] = (i as u32, axis));
            }
        }
        Crossing {
            nodes: points.iter().map(node).collect(),
            point_of,
            rows: Vec::with_capacity(keys.len()),
            terms: Vec::with_capacity(16 * keys.len()),
            keys,
            most: vec![0.0; points.len()],
        }
    }

    /// Takes the rows of an increment before any is left out, with the pressures of the increment before.
    pub(super) fn take(&mut self, rows: &Rows, laws: &[Law], pressures: &[[f64; 2]]) {
        let Crossing { nodes, point_of, keys, rows: passings, terms, most } = self;
        passings.clear();
        terms.clear();
        most.fill(0.0);
        for row in &rows.rows {
            let (begin, law) = (terms.len(), &laws[row.law as usize].heat);
            let whole = weigh(rows.terms_of(row), keys[row.key as usize].0, (point_of, nodes), terms);
            let mut conducts = 0.0;
            if whole && !row.alone {
                conducts = row.area * law.conductance(row.gap / row.area, pressures[row.key as usize][0]);
                let bound = row.area * law.most();
                terms[begin..].iter().for_each(|&(p, weight)| most[p as usize] += bound * weight.abs());
            }
            let terms = [begin as u32, terms.len() as u32];
            passings.push(Passing { key: row.key, terms, conducts, made: [0.0; 2] });
        }
    }

    /// Takes what friction makes of its work in the rows that are left.
    pub(super) fn rub(&mut self, rows: &Rows, laws: &[Law], work: impl Fn(&Row) -> f64) {
        let mut at = 0;
        for row in rows.rows.iter().filter(|row| row.sheared != 0.0) {
            while self.rows[at].key != row.key {
                at += 1;
            }
            let law = &laws[row.law as usize].heat;
            let own = if self.keys[row.key as usize].1 { law.to_first } else { 1.0 - law.to_first };
            let heat = -law.fraction * work(row);
            self.rows[at].made = [own * heat, (1.0 - own) * heat];
        }
    }

    /// What each point could at most exchange.
    pub(super) fn kept_mut(&mut self) -> &mut [f64] {
        &mut self.most
    }

    /// The same, to be looked at.
    pub(super) fn kept(&self) -> &[f64] {
        &self.most
    }

    pub(super) fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.nodes)
            + MemoryUse::of(&self.point_of)
            + MemoryUse::of(&self.keys)
            + MemoryUse::of(&self.rows)
            + MemoryUse::of(&self.terms)
            + MemoryUse::of(&self.most)
    }
}

impl HeatExchange for Crossing {
    fn exchange(&self, temperature: &[f64], dt: f64, into: &mut dyn FnMut(usize, f64)) -> f64 {
        let mut rubbed = 0.0;
        for row in &self.rows {
            let own = &self.terms[row.terms[0] as usize..row.terms[1] as usize];
            let difference: f64 = own.iter().map(|&(p, w)| w * temperature[self.nodes[p as usize] as usize]).sum();
            let flow = if row.conducts == 0.0 { 0.0 } else { row.conducts * difference };
            for &(p, weight) in own {
                let made = if weight < 0.0 { -weight * row.made[0] } else { weight * row.made[1] } / dt;
                rubbed += made;
                let heat = made - weight * flow;
                if heat != 0.0 {
                    into(self.nodes[p as usize] as usize, heat);
                }
            }
        }
        rubbed
    }

    fn largest_exchange(&self, into: &mut dyn FnMut(usize, f64)) {
        for (&node, &most) in self.nodes.iter().zip(&self.most).filter(|m| *m.1 > 0.0) {
            into(node as usize, most);
        }
    }
}

// Rows are found anew in the next increment.
persist_struct!(Crossing { most: fixed } derived { nodes, point_of, keys, rows, terms });

/// Adds the points of a row that have a temperature with their weights, by the share of each in the gap along the normal of the own
/// point; returns whether all have one.
fn weigh(of: &[Term], own: u32, (point_of, nodes): (&[(u32, usize)], &[u32]), terms: &mut Vec<(u32, f64)>) -> bool {
    let along = |axis: usize| of.iter().find(|t| point_of[t.dof as usize] == (own, axis)).map_or(0.0, |t| t.normal);
    let normal = [along(0), along(1)];
    let begin = terms.len();
    let mut whole = true;
    for term in of {
        let (point, axis) = point_of[term.dof as usize];
        if point == NONE || nodes[point as usize] == NONE {
            whole = false;
            continue;
        }
        let share = term.normal * normal[axis];
        match terms[begin..].iter_mut().find(|t| t.0 == point) {
            Some(known) => known.1 -= share,
            None => terms.push((point, -share)),
        }
    }
    let sum = |negative: bool, terms: &[(u32, f64)]| {
        terms.iter().filter(|t| (t.1 < 0.0) == negative).map(|t| t.1.abs()).sum::<f64>()
    };
    let sums = [sum(true, &terms[begin..]), sum(false, &terms[begin..])];
    for term in &mut terms[begin..] {
        let sum = sums[usize::from(term.1 >= 0.0)];
        term.1 /= if sum > 0.0 { sum } else { 1.0 };
    }
    whole && sums[0] > 0.0 && sums[1] > 0.0
}
