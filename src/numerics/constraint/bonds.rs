//! Conversion of linear equations and of nodes with equal motion into [`EquationSystem`]s that can be solved.
//!
//! A degree of freedom that has no mass and no prescribed motion is eliminated from the equations (Gaussian
//! elimination). Its motion follows from the other degrees of freedom of one equation, and its load is transferred to
//! them.

use std::collections::{HashMap, HashSet};

use super::system::{EquationSystem, EquationUnknown, change_velocity, load};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{Memory, sorted_unique};
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;

/// A linear equation, `sum of c u = 0`, between degrees of freedom of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalEquation {
    /// Degree of freedom (node; axis, 0 along r and 1 along z) and coefficient of each term.
    pub terms: Vec<((usize, usize), f64)>,
    /// Whether the equation is dropped, instead of an error, if it depends linearly on others.
    pub is_redundant: bool,
}

impl NodalEquation {
    /// Returns the degree of freedom (node, axis) of the first term.
    ///
    /// # Panics
    /// If the equation has no terms.
    pub fn dependent(&self) -> (usize, usize) {
        self.terms[0].0
    }

    /// Adds the terms of another equation, multiplied by a factor.
    pub fn add(&mut self, terms: &[((usize, usize), f64)], factor: f64) {
        for &(dof, c) in terms {
            match self.terms.iter_mut().find(|term| term.0 == dof) {
                Some(term) => term.1 += factor * c,
                None => self.terms.push((dof, factor * c)),
            }
        }
    }
}

/// Nodes with equal motion along an axis. The motion is computed at the first node and copied to the others.
#[derive(Clone, Debug, PartialEq, Memory)]
pub struct MergedDofs {
    pub nodes: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
}

/// Degrees of freedom with a prescribed motion, as node and axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrescribedDofs {
    /// Degrees of freedom whose motion is prescribed, zero or not.
    pub all: HashSet<(usize, usize)>,
    /// Degrees of freedom whose prescribed motion is zero.
    pub held: HashSet<(usize, usize)>,
}

/// An equation that depends linearly on others.
#[derive(Clone, Debug, PartialEq)]
pub struct DependentEquation {
    /// Index of the equation.
    pub equation: usize,
    /// Indices of the equations that it depends on; empty if all its degrees of freedom are prescribed.
    pub follows_from: Vec<usize>,
}

/// Reason why equations cannot be satisfied.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkConflict {
    /// An equation depends linearly on others.
    Dependent(DependentEquation),
    /// Two nodes with equal motion have different prescribed motions along the axis.
    ConflictingMotions([usize; 2], usize),
}

/// Equations and groups of nodes with equal motion, ready to be solved.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: systems, followers; derived: unknowns, loaded)]
pub struct LinkSystem {
    /// Independent systems, groups of nodes with equal motion included.
    pub systems: Vec<EquationSystem>,
    pub(super) followers: Vec<MasslessFollower>,
    /// Node and axis of each member of an unknown, with the indices of its system and in the system, ascending.
    unknowns: Vec<((usize, usize), [u32; 2])>,
    /// Node and axis of each prescribed motion that takes a part of the load of a follower, with the follower, ascending.
    loaded: Vec<((usize, usize), u32)>,
}

/// Nodes without mass along one axis. Their motion is a weighted sum of other degrees of freedom.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: members, axis, terms)]
pub(super) struct MasslessFollower {
    members: Vec<usize>,
    axis: usize,
    terms: Vec<FollowerTerm>,
    /// Load on the nodes, which is transferred to the terms.
    load: f64,
}

#[derive(Clone, Copy, Debug)]
struct FollowerTerm {
    node: usize,
    axis: usize,
    weight: f64,
    /// Whether the motion is prescribed.
    is_prescribed: bool,
}

/// Terms of an equation: index of the unknown, coefficient.
type EquationRow = Vec<(usize, f64)>;

impl LinkSystem {
    /// Builds the systems from equations, groups of nodes with equal motion, nodal masses and prescribed motions.
    ///
    /// # Errors
    /// If an equation depends on others, or a group has two different prescribed motions.
    pub fn new(
        equations: &[NodalEquation],
        alike: &[MergedDofs],
        mass: &[f64],
        given: &PrescribedDofs,
    ) -> Result<LinkSystem, LinkConflict> {
        let mut builder = UnknownBuilder { mass, given, unknowns: Vec::new(), places: HashMap::new() };
        for group in alike {
            builder.add_merged(group)?;
        }
        let mut rows: Vec<Option<EquationRow>> = equations.iter().map(|e| Some(builder.row(e))).collect();
        let unknowns = builder.unknowns;
        let followers = eliminate_massless(&unknowns, &mut rows);
        for (i, row) in rows.iter_mut().enumerate() {
            let rigid = row.as_ref().is_some_and(|r| r.iter().all(|t| unknowns[t.0].inverse_mass == 0.0));
            if rigid && equations[i].is_redundant {
                *row = None;
            }
        }
        let systems = systems(&unknowns, &rows, equations).map_err(LinkConflict::Dependent)?;
        let followers = followers.into_iter().map(|f| f.over_nodes(&unknowns, mass)).collect();
        Ok(LinkSystem { systems, followers, ..LinkSystem::default() }.with_lists())
    }

    /// Lists the degrees of freedom.
    fn with_lists(mut self) -> LinkSystem {
        for (index, system) in (0..).zip(&self.systems) {
            self.unknowns.extend(system.members().map(|(place, unknown)| (place, [index, unknown])));
        }
        for (index, follower) in (0..).zip(&self.followers) {
            let prescribed = follower.terms.iter().filter(|term| term.is_prescribed);
            self.loaded.extend(prescribed.map(|term| ((term.node, term.axis), index)));
        }
        self.unknowns.sort_unstable();
        self.loaded.sort_unstable();
        self.loaded.dedup();
        self
    }

    /// Returns the indices of the system to which a degree of freedom belongs and of its unknown; `None` without one.
    fn unknown(&self, place: (usize, usize)) -> Option<[usize; 2]> {
        let from = self.unknowns.partition_point(|known| known.0 < place);
        self.unknowns.get(from).filter(|known| known.0 == place).map(|known| known.1.inline_map(|index| index as usize))
    }

    /// Iterates over the followers whose loads act on a degree of freedom with a prescribed motion.
    fn loads(&self, place: (usize, usize)) -> impl Iterator<Item = &MasslessFollower> {
        let from = self.loaded.partition_point(|known| known.0 < place);
        let of_place = self.loaded[from..].iter().take_while(move |known| known.0 == place);
        of_place.map(|known| &self.followers[known.1 as usize])
    }

    /// Returns the force of the equations on a degree of freedom.
    pub(super) fn constraint_force(&self, (node, axis): (usize, usize)) -> f64 {
        let unknown = self.unknown((node, axis));
        let of_system = unknown.map_or(0.0, |[system, index]| self.systems[system].constraint_force(index, node));
        self.loads((node, axis)).fold(of_system, |sum, follower| sum + follower.constraint_force(node, axis))
    }

    /// Returns the impulse on a degree of freedom by which the equations corrected velocities in the previous increment.
    pub(super) fn velocity_impulse(&self, (node, axis): (usize, usize)) -> f64 {
        let unknown = self.unknown((node, axis));
        unknown.map_or(0.0, |[system, index]| self.systems[system].velocity_impulse(index, node))
    }

    /// Returns whether the equations act on a degree of freedom.
    pub(super) fn acts_on(&self, place: (usize, usize)) -> bool {
        self.unknown(place).is_some() || self.loads(place).next().is_some()
    }
}

/// Unknowns collected while the equations are read.
struct UnknownBuilder<'a> {
    mass: &'a [f64],
    given: &'a PrescribedDofs,
    unknowns: Vec<EquationUnknown>,
    places: HashMap<(usize, usize), usize>,
}

impl UnknownBuilder<'_> {
    /// Adds one unknown for nodes with equal motion. If several of them are fixed, the first one represents the others.
    fn add_merged(&mut self, group: &MergedDofs) -> Result<(), LinkConflict> {
        let axis = group.axis;
        let is_given = |n: &&usize| self.given.all.contains(&(**n, axis));
        let prescribed: Vec<usize> = group.nodes.iter().filter(is_given).copied().collect();
        let is_held = |n: &usize| self.given.held.contains(&(*n, axis));
        if prescribed.len() > 1 && !prescribed.iter().all(is_held) {
            return Err(LinkConflict::ConflictingMotions([prescribed[0], prescribed[1]], axis));
        }
        let mut members = group.nodes.clone();
        if let Some(&leader) = prescribed.first() {
            members.retain(|n| !prescribed.contains(n));
            members.insert(0, leader);
        }
        let index = self.unknowns.len();
        group.nodes.iter().for_each(|&n| {
            self.places.insert((n, axis), index);
        });
        self.add(members, axis, !prescribed.is_empty());
        Ok(())
    }

    fn add(&mut self, members: Vec<usize>, axis: usize, given: bool) {
        let mass: f64 = members.iter().map(|&n| self.mass[n]).sum();
        // Infinite without mass.
        let inverse_mass = if given { 0.0 } else { 1.0 / mass };
        self.unknowns.push(EquationUnknown { members, axis, inverse_mass, ..EquationUnknown::default() });
    }

    fn row(&mut self, equation: &NodalEquation) -> EquationRow {
        let mut row = EquationRow::new();
        for &((node, axis), c) in &equation.terms {
            let index = match self.places.get(&(node, axis)) {
                Some(&index) => index,
                None => {
                    self.places.insert((node, axis), self.unknowns.len());
                    self.add(vec![node], axis, self.given.all.contains(&(node, axis)));
                    self.unknowns.len() - 1
                }
            };
            row.push((index, c));
        }
        if row.iter().any(|t| self.unknowns[t.0].is_shared()) { merged(row) } else { row }
    }
}

/// Combines terms of the same unknown and drops terms whose coefficients cancel.
fn merged(row: EquationRow) -> EquationRow {
    let largest = row.iter().fold(0.0_f64, |m, t| m.max(t.1.abs()));
    let mut merged = EquationRow::new();
    for (f, c) in row {
        match merged.iter_mut().find(|t| t.0 == f) {
            Some(known) => known.1 += c,
            None => merged.push((f, c)),
        }
    }
    merged.retain(|t| t.1.abs() > 1e-13 * largest);
    merged
}

/// An unknown without mass as a weighted sum of other unknowns.
struct MasslessUnknown {
    unknown: usize,
    terms: EquationRow,
}

/// Eliminates unknowns without mass; each uses one row.
fn eliminate_massless(unknowns: &[EquationUnknown], rows: &mut [Option<EquationRow>]) -> Vec<MasslessUnknown> {
    let mut eliminated: Vec<MasslessUnknown> = Vec::new();
    for x in (0..unknowns.len()).filter(|&x| unknowns[x].inverse_mass.is_infinite()) {
        let coefficient = |row: &EquationRow| row.iter().filter(|t| t.0 == x).map(|t| t.1).sum::<f64>();
        let Some(at) = rows.iter().position(|r| r.as_ref().is_some_and(|r| coefficient(r) != 0.0)) else {
            eliminated.push(MasslessUnknown { unknown: x, terms: EquationRow::new() });
            continue;
        };
        let Some(pivot) = rows[at].take() else { continue };
        let pivot_coefficient = coefficient(&pivot);
        let terms: EquationRow = pivot.iter().filter(|t| t.0 != x).map(|&(f, c)| (f, -c / pivot_coefficient)).collect();
        for row in rows.iter_mut().flatten() {
            let c = coefficient(row);
            if c != 0.0 {
                row.retain(|t| t.0 != x);
                row.extend(terms.iter().map(|&(f, weight)| (f, c * weight)));
                *row = merged(std::mem::take(row));
            }
        }
        eliminated.push(MasslessUnknown { unknown: x, terms });
    }
    // Rows that were eliminated first may contain unknowns that were eliminated later.
    for i in (0..eliminated.len()).rev() {
        let mut terms = EquationRow::new();
        for &(f, weight) in &eliminated[i].terms {
            match eliminated[i + 1..].iter().find(|l| l.unknown == f) {
                Some(later) => terms.extend(later.terms.iter().map(|&(g, w)| (g, weight * w))),
                None => terms.push((f, weight)),
            }
        }
        eliminated[i].terms = merged(terms);
    }
    eliminated
}

/// Groups rows that share unknowns into systems; unknowns keep the order of their first use.
fn systems(
    unknowns: &[EquationUnknown],
    rows: &[Option<EquationRow>],
    equations: &[NodalEquation],
) -> Result<Vec<EquationSystem>, DependentEquation> {
    let mut rows_of_unknown: Vec<Vec<usize>> = vec![Vec::new(); unknowns.len()];
    for (i, row) in rows.iter().enumerate() {
        row.iter().flatten().for_each(|t| rows_of_unknown[t.0].push(i));
    }
    let mut taken: Vec<bool> = rows.iter().map(Option::is_none).collect();
    let mut systems = Vec::new();
    for first in 0..rows.len() {
        if std::mem::replace(&mut taken[first], true) {
            continue;
        }
        let mut members = vec![first];
        let mut next_member = 0;
        while next_member < members.len() {
            let terms = rows[members[next_member]].iter().flatten();
            let next: Vec<usize> =
                sorted_unique(terms.flat_map(|t| &rows_of_unknown[t.0]).copied().filter(|&e| !taken[e]));
            next.iter().for_each(|&e| taken[e] = true);
            members.extend(next);
            next_member += 1;
        }
        systems.push(system(unknowns, rows, &members, equations)?);
    }
    let unlinked = unknowns
        .iter()
        .enumerate()
        .filter(|(i, f)| f.is_shared() && f.inverse_mass.is_finite() && rows_of_unknown[*i].is_empty());
    systems.extend(unlinked.map(|(_, f)| EquationSystem::without_equations(f.clone())));
    Ok(systems)
}

fn system(
    all: &[EquationUnknown],
    rows: &[Option<EquationRow>],
    members: &[usize],
    equations: &[NodalEquation],
) -> Result<EquationSystem, DependentEquation> {
    let mut places: HashMap<usize, usize> = HashMap::new();
    let mut unknowns = Vec::new();
    let mut member_rows = Vec::with_capacity(members.len());
    for &member in members {
        let mut row = EquationRow::new();
        for &(f, c) in rows[member].iter().flatten() {
            let index = *places.entry(f).or_insert(unknowns.len());
            if index == unknowns.len() {
                unknowns.push(all[f].clone());
            }
            row.push((index, c));
        }
        member_rows.push(row);
    }
    EquationSystem::new(unknowns, member_rows, members, members.iter().map(|&m| equations[m].is_redundant).collect())
}

impl MasslessUnknown {
    /// Converts to nodes: a term refers to a node with mass of its group, or to the node with the prescribed motion.
    fn over_nodes(self, unknowns: &[EquationUnknown], mass: &[f64]) -> MasslessFollower {
        let EquationUnknown { members, axis, .. } = unknowns[self.unknown].clone();
        let term = |&(f, weight): &(usize, f64)| {
            let unknown = &unknowns[f];
            let is_prescribed = unknown.inverse_mass == 0.0;
            let heavy = unknown.members.iter().copied().find(|&n| mass[n] > 0.0);
            let node = heavy.filter(|_| !is_prescribed).unwrap_or(unknown.members[0]);
            FollowerTerm { node, axis: unknown.axis, weight, is_prescribed }
        };
        // An unknown whose motion nothing determines contributes nothing.
        let moving = self.terms.iter().filter(|t| unknowns[t.0].inverse_mass.is_finite());
        MasslessFollower { members, axis, terms: moving.map(term).collect(), load: 0.0 }
    }
}

impl MasslessFollower {
    /// Transfers its load to the nodes that it follows.
    pub fn transfer_load(&mut self, dofs: &mut Dofs) {
        self.load = self.members.iter().map(|&n| load(dofs, n, self.axis)).sum();
        if self.load == 0.0 {
            return;
        }
        for t in self.terms.iter().filter(|t| !t.is_prescribed) {
            let inverse = dofs.nodes.inverse_mass[t.node];
            dofs.nodes.acceleration[t.node][t.axis] += t.weight * self.load * inverse;
        }
        // The pass over nodes added no kinetic energy of this force, because the node has no mass.
        let velocity = *dofs.nodes[self.members[0]].velocity(self.axis);
        dofs.energies.kinetic += 0.5 * dofs.nodes.previous_dt * velocity * self.load;
    }

    /// Sets the acceleration of the node from those of the nodes that it follows.
    pub fn accelerate(&self, dofs: &mut Dofs) {
        let acceleration = self.terms.iter().map(|t| t.weight * dofs.nodes.acceleration[t.node][t.axis]).sum();
        self.members.iter().for_each(|&n| dofs.nodes.acceleration[n][self.axis] = acceleration);
    }

    /// Sets the velocity of the node from those of the nodes that it follows, and adds the work of prescribed motions
    /// against its load.
    pub fn follow_velocity(&self, dofs: &mut Dofs, dt: f64, half: f64) {
        let velocity: f64 = self.terms.iter().map(|t| t.weight * *dofs.nodes[t.node].velocity(t.axis)).sum();
        for &n in &self.members {
            let change = velocity - *dofs.nodes[n].velocity(self.axis);
            change_velocity(&mut dofs.nodes, (n, self.axis), change, dt, half);
        }
        for t in self.terms.iter().filter(|t| t.is_prescribed) {
            let new = *dofs.nodes[t.node].velocity(t.axis);
            let old = new - half * dofs.nodes.acceleration[t.node][t.axis];
            dofs.energies.external -= 0.5 * (old + new) * half * t.weight * self.load;
        }
    }

    /// Returns the part of the load that acts on a degree of freedom with a prescribed motion.
    pub fn constraint_force(&self, node: usize, axis: usize) -> f64 {
        let terms = self.terms.iter().filter(|t| t.is_prescribed && (t.node, t.axis) == (node, axis));
        terms.map(|t| t.weight * self.load).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{DependentEquation, LinkConflict, LinkSystem, MergedDofs, NodalEquation, PrescribedDofs};
    use crate::state::dofs::Dofs;
    use crate::state::nodes::{Node, Nodes};

    /// Returns an equation between displacements of nodes along z.
    fn equation(terms: &[(usize, f64)]) -> NodalEquation {
        NodalEquation { terms: terms.iter().map(|&(node, c)| ((node, 1), c)).collect(), is_redundant: false }
    }

    fn bonds(equations: &[NodalEquation], alike: &[MergedDofs], mass: &[f64]) -> Result<LinkSystem, LinkConflict> {
        LinkSystem::new(equations, alike, mass, &PrescribedDofs::default())
    }

    /// Returns the accelerations along z of nodes under forces and equations.
    fn accelerations(equations: &[NodalEquation], alike: &[MergedDofs], mass: &[f64], force: &[f64]) -> Vec<f64> {
        let mut dofs = Dofs { nodes: Nodes::new(vec![Node::default(); mass.len()], mass.to_vec()), ..Dofs::default() };
        dofs.nodes.resize_forces(true);
        for (n, f) in force.iter().enumerate() {
            dofs.nodes.forces[0][n] = [0.0, *f];
            dofs.nodes.acceleration[n] = [0.0, f * dofs.nodes.inverse_mass[n]];
        }
        let mut constraint =
            super::super::equation::EquationConstraint::new(0, bonds(equations, alike, mass).expect("kept"));
        let clock = crate::state::magnitude::AmplitudeClock { now: Default::default(), user_amplitudes: &[] };
        crate::constraint::Constraint::accelerations(&mut constraint, &mut dofs, &clock);
        dofs.nodes.acceleration.iter().map(|a| a[1]).collect()
    }

    #[test]
    fn dependent_equations_are_errors_unless_redundant() {
        let pair = |a: f64, b: f64| equation(&[(0, a), (1, b)]);
        let mass = [1.0, 2.0];
        assert_eq!(bonds(&[pair(1.0, -1.0)], &[], &mass).map(|b| b.systems.len()), Ok(1));
        let twice = LinkConflict::Dependent(DependentEquation { equation: 1, follows_from: vec![0] });
        assert_eq!(bonds(&[pair(1.0, -1.0), pair(2.0, -2.0)], &[], &mass).map(|b| b.systems.len()), Err(twice));
        let spare = NodalEquation { is_redundant: true, ..pair(2.0, -2.0) };
        assert_eq!(bonds(&[pair(1.0, -1.0), spare], &[], &mass).map(|b| b.systems.len()), Ok(1));
    }

    #[test]
    fn chained_equations_share_one_acceleration() {
        let equal = |a: usize, b: usize| equation(&[(a, 1.0), (b, -1.0)]);
        let chain = [equal(0, 1), equal(1, 2)];
        assert_eq!(bonds(&chain, &[], &[1.0, 2.0, 3.0]).map(|b| b.systems.len()), Ok(1));
        // The common acceleration is the total force over the total mass, 1.
        let result = accelerations(&chain, &[], &[1.0, 2.0, 3.0], &[6.0, 0.0, 0.0]);
        assert!(result.iter().all(|a| (a - 1.0).abs() < 1e-14), "{result:?}");
        // The same for nodes with equal motion; the force acts on the one without mass.
        let alike = [MergedDofs { nodes: vec![3, 0, 1, 2], axis: 1 }];
        let result = accelerations(&[], &alike, &[1.0, 2.0, 3.0, 0.0], &[0.0, 0.0, 0.0, 6.0]);
        assert!(result.iter().all(|a| (a - 1.0).abs() < 1e-14), "{result:?}");
    }

    /// A lever without mass, u2 = (u0 + 2 u1) / 3: the load is distributed to the ends with these weights.
    #[test]
    fn massless_nodes_transfer_their_load() {
        let lever = [equation(&[(2, 3.0), (0, -1.0), (1, -2.0)])];
        let result = accelerations(&lever, &[], &[1.0, 4.0, 0.0], &[0.0, 0.0, 3.0]);
        assert_eq!(result, [1.0, 0.5, (1.0 + 2.0 * 0.5) / 3.0]);
        // Two equations for the massless node leave the equation u0 = u1, and the load acts on both.
        let both = [equation(&[(2, 1.0), (0, -1.0)]), equation(&[(2, 1.0), (1, -1.0)])];
        let result = accelerations(&both, &[], &[1.0, 4.0, 0.0], &[0.0, 0.0, 5.0]);
        assert!(result.iter().all(|a| (a - 1.0).abs() < 1e-14), "{result:?}");
    }

    #[test]
    fn conflicting_motions_of_merged_nodes_are_errors() {
        let alike = [MergedDofs { nodes: vec![0, 1], axis: 1 }];
        let mut prescribed = PrescribedDofs { all: [(0, 1), (1, 1)].into(), held: [(0, 1)].into() };
        let conflict = LinkSystem::new(&[], &alike, &[1.0, 1.0], &prescribed).map(|b| b.systems.len());
        assert_eq!(conflict, Err(LinkConflict::ConflictingMotions([0, 1], 1)));
        // If both are fixed, no equation remains.
        prescribed.held.insert((1, 1));
        assert_eq!(LinkSystem::new(&[], &alike, &[1.0, 1.0], &prescribed).map(|b| b.systems.len()), Ok(0));
    }
}
