//! Springs and dashpots between two nodes, or between a node and the ground: SPRINGA and DASHPOTA act along the line
//! between their ends, SPRING1 and DASHPOT1 along an axis (ABAQUS Elements Guide, "Springs", "Dashpots").

use std::collections::BTreeMap;

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::platform::PortableMath as _;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Force law of a spring or dashpot.
#[derive(Clone, Debug, PartialEq)]
pub enum SpringDashpotLaw {
    /// Linear spring: force per length.
    Spring(f64),
    /// Nonlinear spring: rows of relative displacement and force, ascending; constant beyond the ends.
    Table(Vec<[f64; 2]>),
    /// Linear dashpot: force per velocity.
    Dashpot(f64),
    /// Nonlinear dashpot: rows of relative velocity and force, ascending; constant beyond the ends.
    DashpotTable(Vec<[f64; 2]>),
}

/// Interpolates the force in rows of abscissa and force.
fn interpolate(rows: &[[f64; 2]], at: f64) -> f64 {
    let next = rows.partition_point(|r| r[0] <= at);
    let (Some(a), Some(b)) = (rows.get(next.wrapping_sub(1)), rows.get(next)) else {
        return if next == 0 { rows[0][1] } else { rows[next - 1][1] };
    };
    a[1] + (b[1] - a[1]) * (at - a[0]) / (b[0] - a[0])
}

/// Returns the steepest slope of a table.
fn steepest(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|w| ((w[1][1] - w[0][1]) / (w[1][0] - w[0][0])).abs()).fold(0.0, f64::max)
}

impl SpringDashpotLaw {
    fn force(&self, displacement: f64, velocity: f64) -> f64 {
        match self {
            SpringDashpotLaw::Spring(stiffness) => stiffness * displacement,
            SpringDashpotLaw::Dashpot(coefficient) => coefficient * velocity,
            SpringDashpotLaw::Table(rows) => interpolate(rows, displacement),
            SpringDashpotLaw::DashpotTable(rows) => interpolate(rows, velocity),
        }
    }

    /// Returns the energy that a spring has released from its initial state at a relative displacement: that of a
    /// preload, or of a negative stiffness.
    fn released(&self, displacement: f64) -> f64 {
        match self {
            SpringDashpotLaw::Spring(stiffness) => (-0.5 * stiffness * displacement * displacement).max(0.0),
            SpringDashpotLaw::Table(rows) => {
                let [low, high] = [displacement.min(0.0), displacement.max(0.0)];
                let between = rows.iter().map(|row| row[0]).filter(|u| *u > low && *u < high);
                let (mut stored, mut last) = (0.0, low);
                for u in between.chain([high]) {
                    stored += 0.5 * (u - last) * (interpolate(rows, last) + interpolate(rows, u));
                    last = u;
                }
                (-stored * displacement.signum()).max(0.0)
            }
            SpringDashpotLaw::Dashpot(_) | SpringDashpotLaw::DashpotTable(_) => 0.0,
        }
    }

    /// Returns stiffness and damping that bound the stable time increment. For a spring table: the steepest slope, or
    /// the largest force over the length if that is more (a force along the line gives stiffness across it).
    fn bounds(&self, length: f64) -> [f64; 2] {
        match self {
            SpringDashpotLaw::Spring(stiffness) => [stiffness.abs(), 0.0],
            SpringDashpotLaw::Dashpot(coefficient) => [0.0, coefficient.abs()],
            SpringDashpotLaw::Table(rows) => {
                let across = rows.iter().map(|r| if length > 0.0 { r[1].abs() / length } else { 0.0 });
                [across.fold(steepest(rows), f64::max), 0.0]
            }
            SpringDashpotLaw::DashpotTable(rows) => [0.0, steepest(rows)],
        }
    }
}

/// A spring or dashpot between two nodes, or between a node and the ground.
#[derive(Clone, Debug, Persist)]
#[persist(derived: ends, axis, law)]
pub struct Connector {
    /// End nodes; `None` is the ground.
    pub ends: [Option<usize>; 2],
    /// 0 along r, 1 along z; `None` along the line between the ends.
    pub axis: Option<usize>,
    pub law: SpringDashpotLaw,
    /// Force on the first end at the previous instant.
    force: [f64; 2],
    /// Energy that has been released from the initial state.
    released: f64,
}

impl Connector {
    pub fn new(ends: [Option<usize>; 2], axis: Option<usize>, law: SpringDashpotLaw) -> Self {
        Connector { ends, axis, law, force: [0.0; 2], released: 0.0 }
    }
}

/// Squared frequency and damping rate of connectors alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct ConnectorBounds {
    square: f64,
    damping: f64,
}

impl ConnectorBounds {
    /// Returns one over the stable time increment of elements and connectors together, given that of the elements.
    pub fn rate(&self, elements: f64) -> f64 {
        damped_rate(elements, self.square, self.damping)
    }
}

/// Returns one over the stable time increment of elements to whose nodes springs and dampers are added, given that of
/// the elements, the squared frequency of the springs alone and the damping rate of the dampers. Squares of frequencies
/// add (Rayleigh). Forces of the velocity half an increment earlier are stable up to 2/ω (sqrt(1 + ξ²) - ξ) with
/// ξ = damping/(2ω).
pub fn damped_rate(elements: f64, square: f64, damping: f64) -> f64 {
    let square = 4.0 * elements * elements + square;
    let half = 0.5 * damping;
    0.5 * ((square + half * half).sqrt() + half)
}

/// Inertia at the end of a connector whose node moves with other nodes, or with a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedEnd {
    /// Node that represents all nodes with this motion.
    pub with: usize,
    /// Acceleration per force on the node; 0 if the motion is prescribed.
    pub inverse_mass: f64,
}

/// All springs and dashpots of a model, and their bound of the time increment.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: list; derived: carried, sums)]
pub struct Connectors {
    list: Vec<Connector>,
    bounds: ConnectorBounds,
    /// End nodes that move with others.
    carried: BTreeMap<usize, CarriedEnd>,
    /// Stiffness and damping of connectors at each node.
    sums: Vec<[f64; 2]>,
}

impl Connectors {
    /// Creates connectors between nodes in the initial configuration. `carried` has the end nodes that move with others.
    ///
    /// Bound of their highest frequency: K = Bᵀ k B has the eigenvalues of sqrt(k) B M⁻¹ Bᵀ sqrt(k). These are at most
    /// the largest row sum (Gershgorin): for each connector the stiffnesses at its ends over the masses there.
    pub fn new(list: Vec<Connector>, nodes: &Nodes, carried: BTreeMap<usize, CarriedEnd>) -> Self {
        let mut sums = vec![[0.0; 2]; nodes.len()];
        for c in &list {
            let length = c.line(|n| nodes.start[n]).map_or(0.0, |l| l.1);
            let bounds = c.law.bounds(length);
            for n in c.ends.into_iter().flatten().map(|n| carried.get(&n).map_or(n, |end| end.with)) {
                sums[n] = [sums[n][0] + bounds[0], sums[n][1] + bounds[1]];
            }
        }
        let mut connectors = Connectors { list, bounds: ConnectorBounds::default(), carried, sums };
        connectors.bound(nodes);
        connectors
    }

    /// Recomputes the bounds with the current masses.
    pub(super) fn bound(&mut self, nodes: &Nodes) {
        self.bounds = ConnectorBounds::default();
        let alone = |n: usize| CarriedEnd { with: n, inverse_mass: nodes.inverse_mass[n] };
        for c in &self.list {
            let ends =
                || c.ends.into_iter().flatten().map(|n| self.carried.get(&n).copied().unwrap_or_else(|| alone(n)));
            let row = |i: usize| ends().map(|end| self.sums[end.with][i] * end.inverse_mass).sum::<f64>();
            self.bounds.square = self.bounds.square.max(row(0));
            self.bounds.damping = self.bounds.damping.max(row(1));
        }
    }

    /// Continues from the same connectors on a previous mesh, and recomputes the bounds with the current masses.
    pub(super) fn follow_new_mesh(&mut self, previous: &Connectors, nodes: &Nodes) {
        for (connector, known) in self.list.iter_mut().zip(&previous.list) {
            (connector.force, connector.released) = (known.force, known.released);
        }
        self.bound(nodes);
    }

    /// Returns one over the stable time increment, given that of the elements.
    pub(super) fn rate(&self, elements: f64) -> f64 {
        self.bounds.rate(elements)
    }

    /// Returns the bound of the damping rate, per time.
    pub(super) fn damping_rate(&self) -> f64 {
        self.bounds.damping
    }

    /// Adds connector forces to the nodal forces. Their work over the previous increment is computed by the trapezoidal
    /// rule, as for all nodal forces; it is strain energy or dissipation and therefore subtracted from the external
    /// work.
    pub(super) fn add_forces(&mut self, dofs: &mut Dofs) {
        let dt = dofs.nodes.unaccounted_dt();
        for connector in &mut self.list {
            let ConnectorOpening { along, displacement, velocity } = connector.opening(&dofs.nodes);
            let size = connector.law.force(displacement, velocity);
            let (force, previous) = (along.inline_map(|a| size * a), connector.force);
            let mut work = 0.0;
            for (n, sign) in connector.ends.into_iter().zip([1.0, -1.0]).filter_map(|(n, s)| Some((n?, s))) {
                let node = &dofs.nodes[n];
                work += 0.5 * dt * sign * ((force[0] + previous[0]) * node.v_r + (force[1] + previous[1]) * node.v_z);
                dofs.nodes.forces[0][n][0] += sign * force[0];
                dofs.nodes.forces[0][n][1] += sign * force[1];
            }
            dofs.energies.external -= work;
            if matches!(connector.law, SpringDashpotLaw::Dashpot(_) | SpringDashpotLaw::DashpotTable(_)) {
                dofs.energies.viscous -= work;
            } else {
                dofs.energies.internal -= work;
            }
            connector.force = force;
            let released = connector.law.released(displacement);
            dofs.energies.supplied += released - std::mem::replace(&mut connector.released, released);
        }
    }

    pub fn bytes(&self) -> usize {
        let table = |c: &Connector| match &c.law {
            SpringDashpotLaw::Table(rows) | SpringDashpotLaw::DashpotTable(rows) => heap_bytes(rows),
            _ => 0,
        };
        heap_bytes(&self.list) + self.list.iter().map(table).sum::<usize>() + heap_bytes(&self.sums)
    }
}

/// Opening of a connector.
struct ConnectorOpening {
    /// Direction in which it opens.
    along: [f64; 2],
    /// Relative displacement.
    displacement: f64,
    /// Relative velocity in the middle of the previous increment, as in ABAQUS/Explicit.
    velocity: f64,
}

impl Connector {
    /// Returns the direction from the first to the second end, and the distance, for given node positions; `None` for a
    /// connector along an axis.
    fn line(&self, place: impl Fn(usize) -> [f64; 2]) -> Option<([f64; 2], f64)> {
        let ([Some(a), Some(b)], None) = (self.ends, self.axis) else { return None };
        let [[r_a, z_a], [r_b, z_b]] = [place(a), place(b)];
        let (dr, dz) = (r_b - r_a, z_b - z_a);
        let length = dr.portable_hypot(dz);
        Some(([dr / length, dz / length], length))
    }

    fn opening(&self, nodes: &Nodes) -> ConnectorOpening {
        let speed = |n: usize| [nodes[n].v_r, nodes[n].v_z];
        match (self.ends, self.line(|n| nodes[n].place())) {
            ([Some(a), Some(b)], Some((along, length))) => {
                let initial_length = self.line(|n| nodes.start[n]).map_or(0.0, |l| l.1);
                let relative = [speed(b)[0] - speed(a)[0], speed(b)[1] - speed(a)[1]];
                let velocity = relative[0] * along[0] + relative[1] * along[1];
                ConnectorOpening { along, displacement: length - initial_length, velocity }
            }
            ([Some(a), _], _) => {
                let axis = self.axis.unwrap_or(1);
                let mut along = [0.0; 2];
                along[axis] = -1.0;
                // The ground is on the negative side: motion along the axis opens the connector.
                ConnectorOpening { along, displacement: nodes.displacement(a)[axis], velocity: speed(a)[axis] }
            }
            _ => ConnectorOpening { along: [0.0; 2], displacement: 0.0, velocity: 0.0 },
        }
    }
}
