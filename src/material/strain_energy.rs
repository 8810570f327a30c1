//! Strain energies of rubber: the part of a change of shape, by principal stretches, and the part of a change of volume
//! (ABAQUS Analysis User's Guide, "Hyperelastic behavior of rubberlike materials"; Theory Guide, "Hyperelastic material
//! behavior").
//! Never here: deformation gradients, rotations.

/// Answer of an energy in its principal directions, of the energy a volume at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// Derivative by the logarithm of each stretch: the deviator of the Kirchhoff stress.
    pub stress: [f64; 3],
    /// Second derivative by it.
    pub stiffness: [f64; 3],
}

/// Energy of a change of shape.
pub trait StrainEnergy: Send + Sync + 'static {
    /// Its derivatives at these squares of the principal stretches, their product 1.
    fn respond(&self, squares: [f64; 3]) -> Principal;
}

/// The highest order of a polynomial.
pub const ORDER: usize = 6;

/// Sum of C_ij (I1 - 3)^i (I2 - 3)^j: Mooney and Rivlin, Yeoh, reduced and full polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// Each C_ij with i and j, which are no higher than [`ORDER`].
    pub terms: Vec<(f64, usize, usize)>,
}

/// x^i with its first and second derivative, for each order.
#[inline(always)]
fn powers(x: f64) -> [[f64; 3]; ORDER + 1] {
    let mut list = [[0.0; 3]; ORDER + 1];
    list[0][0] = 1.0;
    for i in 1..=ORDER {
        let [value, first, second] = list[i - 1];
        list[i] = [value * x, first * x + value, second * x + 2.0 * first];
    }
    list
}

impl StrainEnergy for Polynomial {
    #[inline(always)]
    fn respond(&self, squares: [f64; 3]) -> Principal {
        let inverse = squares.map(|x| 1.0 / x);
        let trace = |x: [f64; 3]| x[0] + x[1] + x[2];
        let (i1, i2) = (trace(squares), trace(inverse));
        let (x, y) = (powers(i1 - 3.0), powers(i2 - 3.0));
        let (mut u1, mut u2, mut u11, mut u12, mut u22) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for &(c, i, j) in &self.terms {
            let ([f, f1, f2], [g, g1, g2]) = (x[i], y[j]);
            u1 += c * f1 * g;
            u2 += c * f * g1;
            u11 += c * f2 * g;
            u12 += c * f1 * g1;
            u22 += c * f * g2;
        }
        let mut answer = Principal { stress: [0.0; 3], stiffness: [0.0; 3] };
        for k in 0..3 {
            // Derivatives of the invariants by the logarithm of a stretch of which a third is taken from each.
            let (a, b) = (2.0 * (squares[k] - i1 * (1.0 / 3.0)), 2.0 * (i2 * (1.0 / 3.0) - inverse[k]));
            let (aa, bb) = (4.0 / 9.0 * (3.0 * squares[k] + i1), 4.0 / 9.0 * (3.0 * inverse[k] + i2));
            answer.stress[k] = u1 * a + u2 * b;
            answer.stiffness[k] = (u11 * a * a + 2.0 * u12 * a * b + u22 * b * b) + (u1 * aa + u2 * bb);
        }
        answer
    }
}

/// Sum of 2 mu_i/alpha_i^2 (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3) (Ogden).
#[derive(Clone, Debug, PartialEq)]
pub struct Ogden {
    /// Each mu and alpha.
    pub terms: Vec<[f64; 2]>,
}

impl StrainEnergy for Ogden {
    #[inline(always)]
    fn respond(&self, squares: [f64; 3]) -> Principal {
        let logarithms = squares.map(libm::log);
        let mut answer = Principal { stress: [0.0; 3], stiffness: [0.0; 3] };
        for &[mu, alpha] in &self.terms {
            let power = logarithms.map(|l| libm::exp(0.5 * alpha * l));
            let third = (power[0] + power[1] + power[2]) * (1.0 / 3.0);
            for (k, power) in power.into_iter().enumerate() {
                answer.stress[k] += 2.0 * mu / alpha * (power - third);
                answer.stiffness[k] += 2.0 / 3.0 * mu * (power + third);
            }
        }
        answer
    }
}

/// Energy of a change of volume: the sum of (J - 1)^(2i)/D_i.
#[derive(Clone, Debug, PartialEq)]
pub struct Compression {
    /// One over each D_i.
    pub inverse: Vec<f64>,
}

impl Compression {
    /// Initial bulk modulus.
    pub fn initial(&self) -> f64 {
        self.inverse.first().map_or(0.0, |inverse| 2.0 * inverse)
    }

    /// First and second derivative by J.
    #[inline(always)]
    pub fn respond(&self, j: f64) -> [f64; 2] {
        let (mut first, mut second) = (0.0, 0.0);
        // (J - 1)^(2i - 2), and 2i.
        let (mut power, mut order) = (1.0, 2.0);
        for inverse in &self.inverse {
            first += order * inverse * power * (j - 1.0);
            second += order * (order - 1.0) * inverse * power;
            power *= (j - 1.0) * (j - 1.0);
            order += 2.0;
        }
        [first, second]
    }
}

#[cfg(test)]
mod tests {
    use super::{Compression, Ogden, Polynomial, Principal, StrainEnergy};

    /// Squares of stretches of product 1 from two logarithms; a third of the change of one is taken from each.
    fn squares(logarithms: [f64; 3]) -> [f64; 3] {
        let third = logarithms.iter().sum::<f64>() / 3.0;
        logarithms.map(|l| (2.0 * (l - third)).exp())
    }

    /// The derivatives against differences of the energy itself.
    fn agrees(law: &impl StrainEnergy, energy: impl Fn([f64; 3]) -> f64) {
        for at in [[0.0, 0.0, 0.0], [0.6, -0.2, 0.1], [-0.4, 0.5, -0.9]] {
            let Principal { stress, stiffness } = law.respond(squares(at));
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut l = at;
                    l[k] += by;
                    energy(squares(l))
                };
                let (step, wide) = (1e-5, 1e-3);
                let first = (moved(step) - moved(-step)) / (2.0 * step);
                let second = (moved(wide) - 2.0 * moved(0.0) + moved(-wide)) / (wide * wide);
                assert!((stress[k] - first).abs() < 1e-8 * (1.0 + first.abs()), "{at:?} {k}: {} {first}", stress[k]);
                assert!((stiffness[k] / second - 1.0).abs() < 1e-4, "{at:?} {k}: {} {second}", stiffness[k]);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_energies() {
        let terms = vec![(0.5, 1, 0), (0.2, 0, 1), (-0.02, 2, 0), (0.01, 1, 1), (0.03, 0, 2), (0.004, 3, 0)];
        let of = terms.clone();
        agrees(&Polynomial { terms }, |s| {
            let (x, y) = (s.iter().sum::<f64>() - 3.0, s.iter().map(|x| 1.0 / x).sum::<f64>() - 3.0);
            of.iter().map(|&(c, i, j)| c * x.powi(i as i32) * y.powi(j as i32)).sum()
        });
        let terms = vec![[0.6, 1.3], [0.01, 5.0], [-0.1, -2.0]];
        let of = terms.clone();
        agrees(&Ogden { terms }, |s| {
            of.iter().map(|[mu, a]| 2.0 * mu / (a * a) * (s.iter().map(|x| x.powf(a / 2.0)).sum::<f64>() - 3.0)).sum()
        });
        let volume = Compression { inverse: vec![10.0, 3.0] };
        let energy = |j: f64| 10.0 * (j - 1.0).powi(2) + 3.0 * (j - 1.0).powi(4);
        let [first, second] = volume.respond(1.3);
        assert!((first - (energy(1.3 + 1e-6) - energy(1.3 - 1e-6)) / 2e-6).abs() < 1e-6);
        assert!((second - (20.0 + 36.0 * 0.09)).abs() < 1e-12 && volume.initial() == 20.0);
    }
}
