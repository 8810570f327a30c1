//! Attitude of a rigid body of revolution in space: vectors, unit quaternions, and the exact motion of a symmetric top that nothing
//! turns. Axes 1, 2, 3: r at angle 0, the axis of symmetry, and the third of a right-handed frame.
//! Never here: forces and moments.

use super::lanes::InlineMap;
/// A vector along 1, 2, 3.
pub type Vector = [f64; 3];

#[inline]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// `a + factor b`.
#[inline]
pub fn plus(a: Vector, factor: f64, b: Vector) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

/// `factor a`.
#[inline]
pub fn times(factor: f64, a: Vector) -> Vector {
    a.inline_map(|x| factor * x)
}

/// Angle between two vectors, radians: 0 where one has no length. Accurate near 0 and pi too.
pub fn angle(a: Vector, b: Vector) -> f64 {
    libm::atan2(norm(cross(a, b)), dot(a, b))
}

/// A rotation as a unit quaternion: the scalar part and the vector part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attitude(pub [f64; 4]);

impl Default for Attitude {
    fn default() -> Self {
        Attitude([1.0, 0.0, 0.0, 0.0])
    }
}

impl Attitude {
    /// The rotation by a rotation vector: about its direction by its length, radians.
    pub fn turned(by: Vector) -> Attitude {
        let angle = norm(by);
        let half = 0.5 * angle;
        let factor = if angle > 0.0 { libm::sin(half) / angle } else { 0.5 };
        Attitude([libm::cos(half), factor * by[0], factor * by[1], factor * by[2]])
    }

    /// This rotation behind another one.
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

    /// The same without what rounding has added to its length.
    #[must_use]
    pub fn normalized(self) -> Attitude {
        let square: f64 = self.0.iter().map(|x| x * x).sum();
        // Newton's step for 1/sqrt next to 1.
        let factor = 1.5 - 0.5 * square;
        Attitude(self.0.inline_map(|x| factor * x))
    }

    /// A vector of the body as the world sees it.
    #[inline]
    pub fn to_world(self, v: Vector) -> Vector {
        let Attitude([w, q @ ..]) = self;
        let t = times(2.0, cross(q, v));
        plus(plus(v, w, t), 1.0, cross(q, t))
    }

    /// A vector of the world as the body sees it.
    #[inline]
    pub fn to_body(self, v: Vector) -> Vector {
        self.inverse().to_world(v)
    }

    /// The axis of symmetry in the world.
    #[inline]
    pub fn axis(self) -> Vector {
        let Attitude([w, x, y, z]) = self;
        [2.0 * (x * y - w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z + w * x)]
    }

    /// The rotation vector, of a length up to pi.
    pub fn vector(self) -> Vector {
        let Attitude([w, q @ ..]) = self;
        let (sine, sign) = (norm(q), if w < 0.0 { -1.0 } else { 1.0 });
        let factor = if sine > 0.0 { 2.0 * libm::atan2(sine, sign * w) / sine } else { 2.0 };
        times(sign * factor, q)
    }
}

/// Moments of inertia of a body of revolution about its centre of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// About the axis of symmetry.
    pub axial: f64,
    /// About any axis across it.
    pub transverse: f64,
}

impl Inertia {
    /// Angular velocity in the world of a body with this axis and angular momentum: L/I_t + (1/I_a - 1/I_t) (L . e) e.
    #[inline]
    pub fn angular_velocity(self, axis: Vector, momentum: Vector) -> Vector {
        let along = dot(momentum, axis);
        plus(times(1.0 / self.transverse, momentum), along * (1.0 / self.axial - 1.0 / self.transverse), axis)
    }

    /// Angular momentum in the world of a body with this axis and angular velocity.
    pub fn momentum(self, axis: Vector, velocity: Vector) -> Vector {
        plus(times(self.transverse, velocity), dot(velocity, axis) * (self.axial - self.transverse), axis)
    }

    /// Energy of rotation.
    #[inline]
    pub fn energy(self, axis: Vector, momentum: Vector) -> f64 {
        0.5 * dot(momentum, self.angular_velocity(axis, momentum))
    }

    /// The attitude a time later of a body that nothing turns, exactly: a symmetric top precesses about its angular momentum at
    /// L/I_t and turns about its own axis at L_a (1/I_a - 1/I_t) beside (Goldstein, Poole and Safko, Classical Mechanics, 5.6).
    pub fn free_motion(self, attitude: Attitude, momentum: Vector, time: f64) -> Attitude {
        if momentum == [0.0; 3] {
            return attitude;
        }
        let along = dot(momentum, attitude.axis());
        let own = [0.0, time * along * (1.0 / self.axial - 1.0 / self.transverse), 0.0];
        let precession = Attitude::turned(times(time / self.transverse, momentum));
        precession.after(attitude).after(Attitude::turned(own)).normalized()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vector, b: Vector, tolerance: f64) {
        assert!(norm(plus(a, -1.0, b)) <= tolerance, "{a:?} and {b:?}");
    }

    #[test]
    fn rotations_compose_and_go_back() {
        let first = Attitude::turned([0.3, -1.1, 0.7]);
        let second = Attitude::turned([0.0, 0.0, 1.3]);
        let v = [0.2, 0.9, -1.7];
        near(second.after(first).to_world(v), second.to_world(first.to_world(v)), 1e-15);
        near(first.to_body(first.to_world(v)), v, 1e-15);
        near(first.axis(), first.to_world([0.0, 1.0, 0.0]), 1e-15);
        near(first.vector(), [0.3, -1.1, 0.7], 1e-15);
        near(Attitude::turned([0.0, 0.0, 0.5]).axis(), [-libm::sin(0.5), libm::cos(0.5), 0.0], 1e-15);
    }

    /// Euler's equations by steps of the fourth order (whose own error is 2e-9 at the largest spin) against the closed form, with the
    /// spin far above and below the rest.
    #[test]
    fn free_motion_is_that_of_eulers_equations() {
        for spin in [-40.0, 0.0, 3.0, 400.0] {
            let inertia = Inertia { axial: 0.3, transverse: 1.7 };
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
