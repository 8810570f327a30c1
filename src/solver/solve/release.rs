//! Release of nodes: the first increment without a boundary condition that has ended.
//!
//! A force that is no longer held accelerates its node from the instant n of the release on. With the time κ over which
//! it acts, v(n+1/2) = v(n-1/2) + κ a. The kinetic energy with the velocities before and after an instant follows the work
//! by the trapezoidal rule if m (v(n+1/2)² - v(n-1/2)²) = f v(n+1/2) Δt, therefore κ = Δt v(n+1/2)/(v(n-1/2) + v(n+1/2)).

use super::run::SolverRun;
use crate::constraint::prescribed_motions;

/// Returns the change κ a of the velocity that conserves energy, for the velocity before the release.
fn velocity_change(velocity: f64, acceleration: f64, dt: f64) -> f64 {
    let (change, twice) = (dt * acceleration.abs(), 2.0 * velocity.abs());
    let root = (twice * twice + change * change).sqrt();
    let along = velocity * acceleration >= 0.0;
    let doubled = if along { change + (root - twice) } else { change - (root - twice) };
    0.5 * doubled * acceleration.signum()
}

impl SolverRun<'_> {
    /// Returns node and axis of all prescribed motions, in ascending order.
    pub(super) fn prescribed_motions(&self) -> Vec<(usize, usize)> {
        let mut list: Vec<(usize, usize)> = prescribed_motions(&self.state.constraints).collect();
        list.sort_unstable();
        list
    }

    /// Finds the nodes that are released at the start of a step: their motion was prescribed before.
    pub(super) fn find_released(&mut self, before: Vec<(usize, usize)>) {
        let now = self.prescribed_motions();
        self.released = before.into_iter().filter(|motion| now.binary_search(motion).is_err()).collect();
    }

    /// Accelerates released nodes over the time that conserves energy, in place of half of the previous and half of the
    /// next increment.
    #[cold]
    pub(super) fn release(&mut self, dt: f64) {
        let nodes = &mut self.state.dofs.nodes;
        let half = 0.5 * (dt + nodes.previous_dt);
        for (node, axis) in self.released.drain(..) {
            let acceleration = nodes.acceleration[node][axis];
            let velocity = nodes[node].velocity(axis);
            *velocity += velocity_change(*velocity, acceleration, dt) - half * acceleration;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::velocity_change;

    /// The kinetic energy m (v v + v a dt)/2 at the next instant less that before is the work of the force over it, for a
    /// node at rest and for one that moves with or against the force.
    #[test]
    fn release_conserves_energy() {
        let (a, next, dt) = (-3.0, -2.5, 0.2);
        for velocity in [0.0, 1e-9, -1e-9, 0.7, -0.7, 50.0, -50.0] {
            let after = velocity + velocity_change(velocity, a, dt);
            let before = 0.5 * velocity * velocity;
            let kinetic = 0.5 * after * (after + dt * next);
            let work = 0.5 * (a + next) * after * dt;
            assert!((kinetic - before - work).abs() < 1e-12 * (1.0 + before), "{velocity}");
        }
        assert_eq!(velocity_change(0.0, a, dt), a * dt);
        assert!((velocity_change(-50.0, a, dt) / (0.5 * a * dt) - 1.0).abs() < 0.01);
    }
}
