//! Attitude of a rigid body of revolution in space: vectors, unit quaternions, and the exact torque-free motion of a
//! symmetric top. Axes 1, 2, 3: r at angle 0, the axis of symmetry, and the third axis of a right-handed frame.

use super::lanes::InlineMap;
use revolve_derive::Persist;
/// A vector with components along 1, 2, 3.
pub type SpatialVector = [f64; 3];

#[inline]
pub fn dot(a: SpatialVector, b: SpatialVector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub fn cross(a: SpatialVector, b: SpatialVector) -> SpatialVector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub fn norm(a: SpatialVector) -> f64 {
    dot(a, a).sqrt()
}

/// Returns the sum of a vector and a multiple of another one, `a + factor b`.
#[inline]
pub fn plus(a: SpatialVector, factor: f64, b: SpatialVector) -> SpatialVector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

/// Returns a multiple of a vector, `factor a`.
#[inline]
pub fn times(factor: f64, a: SpatialVector) -> SpatialVector {
    a.inline_map(|x| factor * x)
}

/// Returns the angle between two vectors, radians; 0 if one has no length. Also accurate near 0 and π.
pub fn angle(a: SpatialVector, b: SpatialVector) -> f64 {
    libm::atan2(norm(cross(a, b)), dot(a, b))
}

/// A rotation as a unit quaternion: scalar part, then vector part.
#[derive(Clone, Copy, Debug, PartialEq, Persist)]
pub struct Attitude(pub [f64; 4]);

impl Default for Attitude {
    fn default() -> Self {
        Attitude([1.0, 0.0, 0.0, 0.0])
    }
}

impl Attitude {
    /// Creates the rotation of a rotation vector, whose length is the angle in radians.
    pub fn turned(by: SpatialVector) -> Attitude {
        let angle = norm(by);
        let half = 0.5 * angle;
        let factor = if angle > 0.0 { libm::sin(half) / angle } else { 0.5 };
        Attitude([libm::cos(half), factor * by[0], factor * by[1], factor * by[2]])
    }

    /// Returns the composition: rotation `first`, then this rotation.
    #[must_use]
    pub fn after(self, first: Attitude) -> Attitude {
        let (Attitude([a, p @ ..]), Attitude([b, q @ ..])) = (self, first);
        let v = plus(plus(times(a, q), b, p), 1.0, cross(p, q));
        Attitude([a * b - dot(p, q), v[0], v[1], v[2]])
    }

    #[must_use]
    pub fn inverse(self) -> Attitude {
        let Attitude([w, x, y, z]) = self;
        Attitude([w, -x, -y, -z])
    }

    /// Returns the quaternion normalised to unit length, for small deviations by rounding.
    #[must_use]
    pub fn normalized(self) -> Attitude {
        let square: f64 = self.0.iter().map(|x| x * x).sum();
        // Newton's step for 1/sqrt near 1.
        let factor = 1.5 - 0.5 * square;
        Attitude(self.0.inline_map(|x| factor * x))
    }

    /// Transforms a vector from the body frame to the global frame.
    #[inline]
    pub fn to_world(self, v: SpatialVector) -> SpatialVector {
        let Attitude([w, q @ ..]) = self;
        let t = times(2.0, cross(q, v));
        plus(plus(v, w, t), 1.0, cross(q, t))
    }

    /// Transforms a vector from the global frame to the body frame.
    #[inline]
    pub fn to_body(self, v: SpatialVector) -> SpatialVector {
        self.inverse().to_world(v)
    }

    /// Returns the axis of symmetry in the global frame.
    #[inline]
    pub fn axis(self) -> SpatialVector {
        let Attitude([w, x, y, z]) = self;
        [2.0 * (x * y - w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z + w * x)]
    }

    /// Returns the rotation vector, with a length up to π.
    pub fn vector(self) -> SpatialVector {
        let Attitude([w, q @ ..]) = self;
        let (sine, sign) = (norm(q), if w < 0.0 { -1.0 } else { 1.0 });
        let factor = if sine > 0.0 { 2.0 * libm::atan2(sine, sign * w) / sine } else { 2.0 };
        times(sign * factor, q)
    }
}

/// Moments of inertia of a body of revolution about its centre of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrincipalInertia {
    /// About the axis of symmetry.
    pub axial: f64,
    /// About any transverse axis.
    pub transverse: f64,
}

impl PrincipalInertia {
    /// Returns the global angular velocity for an axis of symmetry and an angular momentum: L/I_t + (1/I_a - 1/I_t) (L
    /// . e) e. Equation (13.1).
    #[inline]
    pub fn angular_velocity(self, axis: SpatialVector, momentum: SpatialVector) -> SpatialVector {
        let along = dot(momentum, axis);
        plus(times(1.0 / self.transverse, momentum), along * (1.0 / self.axial - 1.0 / self.transverse), axis)
    }

    /// Returns the global angular momentum for an axis of symmetry and an angular velocity.
    pub fn momentum(self, axis: SpatialVector, velocity: SpatialVector) -> SpatialVector {
        plus(times(self.transverse, velocity), dot(velocity, axis) * (self.axial - self.transverse), axis)
    }

    /// Returns the rotational kinetic energy.
    #[inline]
    pub fn energy(self, axis: SpatialVector, momentum: SpatialVector) -> f64 {
        0.5 * dot(momentum, self.angular_velocity(axis, momentum))
    }

    /// Returns the attitude after torque-free motion over a time, exactly: a symmetric top precesses about its angular
    /// momentum at L/I_t, and in addition spins about its own axis at L_a (1/I_a - 1/I_t) (Goldstein, Poole and Safko,
    /// Classical Mechanics, 5.6). Equation (13.2).
    pub fn free_motion(self, attitude: Attitude, momentum: SpatialVector, time: f64) -> Attitude {
        if momentum == [0.0; 3] {
            return attitude;
        }
        let along = dot(momentum, attitude.axis());
        let spin = [0.0, time * along * (1.0 / self.axial - 1.0 / self.transverse), 0.0];
        let precession = Attitude::turned(times(time / self.transverse, momentum));
        precession.after(attitude).after(Attitude::turned(spin)).normalized()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: SpatialVector, b: SpatialVector, tolerance: f64) {
        assert!(norm(plus(a, -1.0, b)) <= tolerance, "{a:?} and {b:?}");
    }

    #[test]
    fn rotations_compose_and_invert() {
        let first = Attitude::turned([0.3, -1.1, 0.7]);
        let second = Attitude::turned([0.0, 0.0, 1.3]);
        let v = [0.2, 0.9, -1.7];
        near(second.after(first).to_world(v), second.to_world(first.to_world(v)), 1e-15);
        near(first.to_body(first.to_world(v)), v, 1e-15);
        near(first.axis(), first.to_world([0.0, 1.0, 0.0]), 1e-15);
        near(first.vector(), [0.3, -1.1, 0.7], 1e-15);
        near(Attitude::turned([0.0, 0.0, 0.5]).axis(), [-libm::sin(0.5), libm::cos(0.5), 0.0], 1e-15);
    }

    /// Closed form compared with Euler's equations integrated to fourth order (error 2e-9 at the largest spin), for
    /// spins far above and below the transverse rates.
    #[test]
    fn free_motion_is_that_of_eulers_equations() {
        for spin in [-40.0, 0.0, 3.0, 400.0] {
            let inertia = PrincipalInertia { axial: 0.3, transverse: 1.7 };
            let start = Attitude::turned([0.4, 0.1, -0.2]);
            let omega = plus([0.9, 0.0, -0.4], spin, start.axis());
            let momentum = inertia.momentum(start.axis(), omega);
            near(inertia.angular_velocity(start.axis(), momentum), omega, 1e-13 * (1.0 + spin.abs()));
            let rate = |q: [f64; 4]| {
                let attitude = Attitude(q);
                let w = inertia.angular_velocity(attitude.axis(), momentum);
                Attitude([0.0, w[0], w[1], w[2]]).after(attitude).0.map(|x| 0.5 * x)
            };
            let add = |q: [f64; 4], f: f64, k: [f64; 4]| std::array::from_fn(|i| q[i] + f * k[i]);
            let (mut q, steps, time) = (start.0, 40_000, 0.5);
            let dt = time / f64::from(steps);
            for _ in 0..steps {
                let a = rate(q);
                let b = rate(add(q, 0.5 * dt, a));
                let c = rate(add(q, 0.5 * dt, b));
                let d = rate(add(q, dt, c));
                q = std::array::from_fn(|i| q[i] + dt / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
            }
            let end = inertia.free_motion(start, momentum, time);
            near(end.axis(), Attitude(q).axis(), 1e-8);
            near(end.to_world([1.0, 0.0, 0.0]), Attitude(q).to_world([1.0, 0.0, 0.0]), 1e-8);
        }
    }
}
