//! From equations, and from nodes that move alike, to systems that can be solved and to nodes without mass that follow.
//! Never here: deck words, their solution.
//!
//! A degree of freedom that has no mass and whose motion is not given cannot resist: it is taken out of the equations by
//! one of them (Gaussian elimination), follows the others there, and hands the loads on it to them.

use std::collections::{HashMap, HashSet};

use super::system::{Freedom, System, load, shift};
use crate::kernel::lists::heap_bytes;
use crate::kernel::lists::sorted_unique;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// One equation: node, axis (0 along r, 1 along z) and coefficient of each term.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    pub terms: Vec<(usize, usize, f64)>,
    /// Whether it may be left out where it follows from others.
    pub spare: bool,
}

/// Nodes that move alike along an axis; the first one leads.
#[derive(Clone, Debug, PartialEq)]
pub struct Alike {
    pub nodes: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
}

/// What is prescribed, as node and axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given {
    pub all: HashSet<(usize, usize)>,
    /// What of it stays where it is.
    pub held: HashSet<(usize, usize)>,
}

/// An equation that cannot be kept beside others.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependent {
    pub equation: usize,
    /// Those that it follows from; none where nothing could move to keep it.
    pub follows_from: Vec<usize>,
}

/// Why nothing can be kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Unkept {
    /// An equation that follows from others.
    Dependent(Dependent),
    /// Two nodes that are to move alike, and an axis along which each is given a motion of its own.
    Torn([usize; 2], usize),
}

/// What keeps nodes together, ready to be solved.
#[derive(Clone, Debug, Default)]
pub struct Bonds {
    pub(super) systems: Vec<System>,
    pub(super) followers: Vec<Follower>,
}

/// Nodes without mass along one axis, and what they follow: a weighted sum.
#[derive(Clone, Debug)]
pub(super) struct Follower {
    members: Vec<usize>,
    axis: usize,
    terms: Vec<Term>,
    /// Load on it, which it hands on.
    load: f64,
}

#[derive(Clone, Copy, Debug)]
struct Term {
    node: usize,
    axis: usize,
    weight: f64,
    /// Whether its motion is given.
    given: bool,
}

/// A row over freedoms: index, coefficient.
type Row = Vec<(usize, f64)>;

impl Bonds {
    /// Of some equations and nodes that move alike, given the masses of nodes and what is prescribed.
    ///
    /// # Errors
    /// What cannot be kept.
    pub fn new(equations: &[Equation], alike: &[Alike], mass: &[f64], given: &Given) -> Result<Bonds, Unkept> {
        let mut makers = Makers { mass, given, freedoms: Vec::new(), places: HashMap::new() };
        for group in alike {
            makers.share(group)?;
        }
        let mut rows: Vec<Option<Row>> = equations.iter().map(|e| Some(makers.row(e))).collect();
        let freedoms = makers.freedoms;
        let followers = loosen(&freedoms, &mut rows);
        for (i, row) in rows.iter_mut().enumerate() {
            let rigid = row.as_ref().is_some_and(|r| r.iter().all(|t| freedoms[t.0].softness == 0.0));
            if rigid && equations[i].spare {
                *row = None;
            }
        }
        let systems = systems(&freedoms, &rows, equations).map_err(Unkept::Dependent)?;
        let followers = followers.into_iter().map(|f| f.over_nodes(&freedoms, mass)).collect();
        Ok(Bonds { systems, followers })
    }

    /// Systems that are independent of each other.
    pub fn systems(&mut self) -> &mut [System] {
        &mut self.systems
    }

    pub fn bytes(&self) -> usize {
        let systems = heap_bytes(&self.systems);
        let own = systems + self.systems.iter().map(System::bytes).sum::<usize>();
        own + self.followers.iter().map(Follower::bytes).sum::<usize>()
    }

    /// Number of equations and of groups that move alike.
    pub fn count(&self) -> usize {
        self.systems.len()
    }
}

/// Unknowns as they come up.
struct Makers<'a> {
    mass: &'a [f64],
    given: &'a Given,
    freedoms: Vec<Freedom>,
    places: HashMap<(usize, usize), usize>,
}

impl Makers<'_> {
    /// One unknown for nodes that move alike. Of several that are held the first one stands for the rest.
    fn share(&mut self, group: &Alike) -> Result<(), Unkept> {
        let axis = group.axis;
        let is_given = |n: &&usize| self.given.all.contains(&(**n, axis));
        let given: Vec<usize> = group.nodes.iter().filter(is_given).copied().collect();
        let is_held = |n: &usize| self.given.held.contains(&(*n, axis));
        if given.len() > 1 && !given.iter().all(is_held) {
            return Err(Unkept::Torn([given[0], given[1]], axis));
        }
        let mut members = group.nodes.clone();
        if let Some(&leader) = given.first() {
            members.retain(|n| !given.contains(n));
            members.insert(0, leader);
        }
        let index = self.freedoms.len();
        group.nodes.iter().for_each(|&n| {
            self.places.insert((n, axis), index);
        });
        self.add(members, axis, !given.is_empty());
        Ok(())
    }

    fn add(&mut self, members: Vec<usize>, axis: usize, given: bool) {
        let mass: f64 = members.iter().map(|&n| self.mass[n]).sum();
        // Infinite without mass: nothing there resists.
        let softness = if given { 0.0 } else { 1.0 / mass };
        self.freedoms.push(Freedom { members, axis, softness, ..Freedom::default() });
    }

    fn row(&mut self, equation: &Equation) -> Row {
        let mut row = Row::new();
        for &(node, axis, c) in &equation.terms {
            let index = match self.places.get(&(node, axis)) {
                Some(&index) => index,
                None => {
                    self.places.insert((node, axis), self.freedoms.len());
                    self.add(vec![node], axis, self.given.all.contains(&(node, axis)));
                    self.freedoms.len() - 1
                }
            };
            row.push((index, c));
        }
        if row.iter().any(|t| self.freedoms[t.0].is_shared()) { merged(row) } else { row }
    }
}

/// With one term for each freedom, and without those whose coefficients cancel.
fn merged(row: Row) -> Row {
    let largest = row.iter().fold(0.0_f64, |m, t| m.max(t.1.abs()));
    let mut merged = Row::new();
    for (f, c) in row {
        match merged.iter_mut().find(|t| t.0 == f) {
            Some(known) => known.1 += c,
            None => merged.push((f, c)),
        }
    }
    merged.retain(|t| t.1.abs() > 1e-13 * largest);
    merged
}

/// What follows, over freedoms.
struct Loose {
    freedom: usize,
    terms: Row,
}

/// Takes freedoms without mass out of the rows, one row for each.
fn loosen(freedoms: &[Freedom], rows: &mut [Option<Row>]) -> Vec<Loose> {
    let mut loose: Vec<Loose> = Vec::new();
    for x in (0..freedoms.len()).filter(|&x| freedoms[x].softness.is_infinite()) {
        let coefficient = |row: &Row| row.iter().filter(|t| t.0 == x).map(|t| t.1).sum::<f64>();
        let Some(at) = rows.iter().position(|r| r.as_ref().is_some_and(|r| coefficient(r) != 0.0)) else {
            loose.push(Loose { freedom: x, terms: Row::new() });
            continue;
        };
        let Some(pivot) = rows[at].take() else { continue };
        let own = coefficient(&pivot);
        let terms: Row = pivot.iter().filter(|t| t.0 != x).map(|&(f, c)| (f, -c / own)).collect();
        for row in rows.iter_mut().flatten() {
            let c = coefficient(row);
            if c != 0.0 {
                row.retain(|t| t.0 != x);
                row.extend(terms.iter().map(|&(f, weight)| (f, c * weight)));
                *row = merged(std::mem::take(row));
            }
        }
        loose.push(Loose { freedom: x, terms });
    }
    // What was taken out later may stand in what was taken out before.
    for i in (0..loose.len()).rev() {
        let mut terms = Row::new();
        for &(f, weight) in &loose[i].terms {
            match loose[i + 1..].iter().find(|l| l.freedom == f) {
                Some(later) => terms.extend(later.terms.iter().map(|&(g, w)| (g, weight * w))),
                None => terms.push((f, weight)),
            }
        }
        loose[i].terms = merged(terms);
    }
    loose
}

/// Rows that share freedoms together, each with its freedoms in the order in which they come up.
fn systems(freedoms: &[Freedom], rows: &[Option<Row>], equations: &[Equation]) -> Result<Vec<System>, Dependent> {
    let mut of_freedom: Vec<Vec<usize>> = vec![Vec::new(); freedoms.len()];
    for (i, row) in rows.iter().enumerate() {
        row.iter().flatten().for_each(|t| of_freedom[t.0].push(i));
    }
    let mut taken: Vec<bool> = rows.iter().map(Option::is_none).collect();
    let mut systems = Vec::new();
    for first in 0..rows.len() {
        if std::mem::replace(&mut taken[first], true) {
            continue;
        }
        let mut members = vec![first];
        let mut at = 0;
        while at < members.len() {
            let own = rows[members[at]].iter().flatten();
            let next: Vec<usize> = sorted_unique(own.flat_map(|t| &of_freedom[t.0]).copied().filter(|&e| !taken[e]));
            next.iter().for_each(|&e| taken[e] = true);
            members.extend(next);
            at += 1;
        }
        systems.push(system(freedoms, rows, &members, equations)?);
    }
    let alone = freedoms
        .iter()
        .enumerate()
        .filter(|(i, f)| f.is_shared() && f.softness.is_finite() && of_freedom[*i].is_empty());
    systems.extend(alone.map(|(_, f)| System::alone(f.clone())));
    Ok(systems)
}

fn system(
    all: &[Freedom],
    rows: &[Option<Row>],
    members: &[usize],
    equations: &[Equation],
) -> Result<System, Dependent> {
    let mut places: HashMap<usize, usize> = HashMap::new();
    let mut freedoms = Vec::new();
    let mut own = Vec::with_capacity(members.len());
    for &member in members {
        let mut row = Row::new();
        for &(f, c) in rows[member].iter().flatten() {
            let place = *places.entry(f).or_insert(freedoms.len());
            if place == freedoms.len() {
                freedoms.push(all[f].clone());
            }
            row.push((place, c));
        }
        own.push(row);
    }
    System::new(freedoms, own, members, members.iter().map(|&m| equations[m].spare).collect())
}

impl Loose {
    /// Over nodes: one with mass, or a given one, stands for all that move alike.
    fn over_nodes(self, freedoms: &[Freedom], mass: &[f64]) -> Follower {
        let Freedom { members, axis, .. } = freedoms[self.freedom].clone();
        let term = |&(f, weight): &(usize, f64)| {
            let freedom = &freedoms[f];
            let given = freedom.softness == 0.0;
            let heavy = freedom.members.iter().copied().find(|&n| mass[n] > 0.0);
            let node = heavy.filter(|_| !given).unwrap_or(freedom.members[0]);
            Term { node, axis: freedom.axis, weight, given }
        };
        // A freedom that nothing moves adds nothing.
        let moving = self.terms.iter().filter(|t| freedoms[t.0].softness.is_finite());
        Follower { members, axis, terms: moving.map(term).collect(), load: 0.0 }
    }
}

impl Follower {
    /// Hands the load on it to what it follows.
    pub fn hand_on(&mut self, dofs: &mut Dofs) {
        self.load = self.members.iter().map(|&n| load(dofs, n, self.axis)).sum();
        if self.load == 0.0 {
            return;
        }
        for t in self.terms.iter().filter(|t| !t.given) {
            let inverse = dofs.nodes.inverse_mass[t.node];
            dofs.nodes.acceleration[t.node][t.axis] += t.weight * self.load * inverse;
        }
        // The pass over nodes took no kinetic energy of this force, as it found no mass.
        let velocity = *dofs.nodes[self.members[0]].velocity(self.axis);
        dofs.energies.kinetic += 0.5 * dofs.nodes.behind * velocity * self.load;
    }

    /// Takes on the acceleration of what it follows.
    pub fn accelerate(&self, dofs: &mut Dofs) {
        let own = self.terms.iter().map(|t| t.weight * dofs.nodes.acceleration[t.node][t.axis]).sum();
        self.members.iter().for_each(|&n| dofs.nodes.acceleration[n][self.axis] = own);
    }

    /// Takes on its velocity, and books the work that motions which are given do against the load.
    pub fn hold_velocity(&self, dofs: &mut Dofs, dt: f64, half: f64) {
        let own: f64 = self.terms.iter().map(|t| t.weight * *dofs.nodes[t.node].velocity(t.axis)).sum();
        for &n in &self.members {
            let change = own - *dofs.nodes[n].velocity(self.axis);
            shift(dofs, n, self.axis, change, dt, half);
        }
        for t in self.terms.iter().filter(|t| t.given) {
            let new = *dofs.nodes[t.node].velocity(t.axis);
            let old = new - half * dofs.nodes.acceleration[t.node][t.axis];
            dofs.energies.external -= 0.5 * (old + new) * half * t.weight * self.load;
        }
    }

    /// The part of the load that a degree of freedom takes whose motion is given.
    pub fn constraint_force(&self, node: usize, axis: usize) -> f64 {
        let own = self.terms.iter().filter(|t| t.given && (t.node, t.axis) == (node, axis));
        own.map(|t| t.weight * self.load).sum()
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.members) + heap_bytes(&self.terms) + size_of_val(self)
    }
}

persist_struct!(Follower { load } derived { members, axis, terms });

persist_struct!(Bonds { systems: fixed, followers: fixed });

#[cfg(test)]
mod tests {
    use super::{Alike, Bonds, Dependent, Equation, Given, Unkept};
    use crate::state::dofs::Dofs;
    use crate::state::nodes::{Node, Nodes};

    fn equation(terms: &[(usize, usize, f64)]) -> Equation {
        Equation { terms: terms.to_vec(), spare: false }
    }

    fn bonds(equations: &[Equation], alike: &[Alike], mass: &[f64]) -> Result<Bonds, Unkept> {
        Bonds::new(equations, alike, mass, &Given::default())
    }

    /// Accelerations along z of nodes on which forces act, under equations.
    fn accelerations(equations: &[Equation], alike: &[Alike], mass: &[f64], force: &[f64]) -> Vec<f64> {
        let mut dofs = Dofs { nodes: Nodes::new(vec![Node::default(); mass.len()], mass.to_vec()), ..Dofs::default() };
        dofs.nodes.make_room(true);
        for (n, f) in force.iter().enumerate() {
            dofs.nodes.forces[0][n] = [0.0, *f];
            dofs.nodes.acceleration[n] = [0.0, f * dofs.nodes.inverse_mass[n]];
        }
        let mut kept = super::super::equation::Equations::new(0, bonds(equations, alike, mass).expect("kept"));
        let clock = crate::state::magnitude::Clock { now: Default::default(), user_amplitudes: &[] };
        crate::constraint::Constraint::accelerations(&mut kept, &mut dofs, &clock);
        dofs.nodes.acceleration.iter().map(|a| a[1]).collect()
    }

    #[test]
    fn equations_that_repeat_are_found() {
        let pair = |a: f64, b: f64| equation(&[(0, 1, a), (1, 1, b)]);
        let mass = [1.0, 2.0];
        assert_eq!(bonds(&[pair(1.0, -1.0)], &[], &mass).map(|b| b.count()), Ok(1));
        let twice = Unkept::Dependent(Dependent { equation: 1, follows_from: vec![0] });
        assert_eq!(bonds(&[pair(1.0, -1.0), pair(2.0, -2.0)], &[], &mass).map(|b| b.count()), Err(twice));
        let spare = Equation { spare: true, ..pair(2.0, -2.0) };
        assert_eq!(bonds(&[pair(1.0, -1.0), spare], &[], &mass).map(|b| b.count()), Ok(1));
    }

    #[test]
    fn a_chain_is_solved_together() {
        let equal = |a: usize, b: usize| equation(&[(a, 1, 1.0), (b, 1, -1.0)]);
        let chain = [equal(0, 1), equal(1, 2)];
        assert_eq!(bonds(&chain, &[], &[1.0, 2.0, 3.0]).map(|b| b.count()), Ok(1));
        // All move with the mean by mass, 1.
        let found = accelerations(&chain, &[], &[1.0, 2.0, 3.0], &[6.0, 0.0, 0.0]);
        assert!(found.iter().all(|a| (a - 1.0).abs() < 1e-14), "{found:?}");
        // So do nodes that are said to move alike, one of them without mass, on which the force acts.
        let alike = [Alike { nodes: vec![3, 0, 1, 2], axis: 1 }];
        let found = accelerations(&[], &alike, &[1.0, 2.0, 3.0, 0.0], &[0.0, 0.0, 0.0, 6.0]);
        assert!(found.iter().all(|a| (a - 1.0).abs() < 1e-14), "{found:?}");
    }

    /// A lever without mass, u2 = (u0 + 2 u1) / 3: its load goes to the ends by the weights.
    #[test]
    fn a_node_without_mass_follows_and_hands_its_load_on() {
        let lever = [equation(&[(2, 1, 3.0), (0, 1, -1.0), (1, 1, -2.0)])];
        let found = accelerations(&lever, &[], &[1.0, 4.0, 0.0], &[0.0, 0.0, 3.0]);
        assert_eq!(found, [1.0, 0.5, (1.0 + 2.0 * 0.5) / 3.0]);
        // Two equations on it leave one between the others: u0 = u1, on which the load acts.
        let both = [equation(&[(2, 1, 1.0), (0, 1, -1.0)]), equation(&[(2, 1, 1.0), (1, 1, -1.0)])];
        let found = accelerations(&both, &[], &[1.0, 4.0, 0.0], &[0.0, 0.0, 5.0]);
        assert!(found.iter().all(|a| (a - 1.0).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn two_motions_on_nodes_that_move_alike_are_found() {
        let alike = [Alike { nodes: vec![0, 1], axis: 1 }];
        let mut given = Given { all: [(0, 1), (1, 1)].into(), held: [(0, 1)].into() };
        let torn = Bonds::new(&[], &alike, &[1.0, 1.0], &given).map(|b| b.count());
        assert_eq!(torn, Err(Unkept::Torn([0, 1], 1)));
        // Both held: nothing is left to keep.
        given.held.insert((1, 1));
        assert_eq!(Bonds::new(&[], &alike, &[1.0, 1.0], &given).map(|b| b.count()), Ok(0));
    }
}
