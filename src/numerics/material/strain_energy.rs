//! Strain energies of rubber: deviatoric part by principal stretches, and volumetric part (ABAQUS Analysis User's
//! Guide, "Hyperelastic behavior of rubberlike materials"; Theory Guide, "Hyperelastic material behavior").
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::transcendental::{exp, ln};

/// Derivatives of a strain energy per initial volume in the principal directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalResponse {
    /// First derivatives with respect to the logarithmic principal stretches: the deviator of the Kirchhoff stress.
    pub stress: [Lanes; 3],
    /// Second derivatives.
    pub stiffness: [Lanes; 3],
}

impl PrincipalResponse {
    const NOTHING: PrincipalResponse = PrincipalResponse { stress: [[0.0; LANES]; 3], stiffness: [[0.0; LANES]; 3] };
}

/// Deviatoric strain energy.
pub trait StrainEnergy: Send + Sync + 'static {
    /// Returns the derivatives of the energy at squared isochoric principal stretches, whose product is 1.
    fn respond(&self, squares: &[Lanes; 3]) -> PrincipalResponse;
}

/// Highest order of a polynomial.
pub const ORDER: usize = 6;

/// Polynomial energy Σ C_ij (I1 - 3)^i (I2 - 3)^j: Mooney-Rivlin, Yeoh, reduced and full polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialEnergy {
    /// Terms C_ij, i, j; the exponents are at most [`ORDER`].
    pub terms: Vec<(f64, usize, usize)>,
}

/// Derivatives of a polynomial with respect to the two invariants.
struct InvariantDerivatives {
    first: [Lanes; 2],
    /// With respect to I1 twice, to both, to I2 twice.
    second: [Lanes; 3],
}

impl PolynomialEnergy {
    #[inline(always)]
    fn derivatives(&self, i1: &Lanes, i2: &Lanes) -> InvariantDerivatives {
        let highest = self.terms.iter().fold(0, |most, term| most.max(term.1).max(term.2));
        let [mut x, mut y] = [[[1.0; LANES]; ORDER + 1]; 2];
        for i in 1..=highest {
            for l in 0..LANES {
                x[i][l] = x[i - 1][l] * (i1[l] - 3.0);
                y[i][l] = y[i - 1][l] * (i2[l] - 3.0);
            }
        }
        let mut sums = InvariantDerivatives { first: [[0.0; LANES]; 2], second: [[0.0; LANES]; 3] };
        for &(c, i, j) in &self.terms {
            // The power x^i and its derivatives: lower powers with their factors.
            let [a, b] = [i, j].inline_map(|n| [n as f64, (n * n.saturating_sub(1)) as f64]);
            let [f, g] =
                [(&x, i), (&y, j)].inline_map(|(list, n)| [0, 1, 2].inline_map(|less| &list[n.saturating_sub(less)]));
            for l in 0..LANES {
                sums.first[0][l] += c * (a[0] * f[1][l] * g[0][l]);
                sums.first[1][l] += c * (b[0] * f[0][l] * g[1][l]);
                sums.second[0][l] += c * (a[1] * f[2][l] * g[0][l]);
                sums.second[1][l] += c * (a[0] * b[0] * f[1][l] * g[1][l]);
                sums.second[2][l] += c * (b[1] * f[0][l] * g[2][l]);
            }
        }
        sums
    }
}

impl StrainEnergy for PolynomialEnergy {
    /// Equation (6.11).
    #[inline(always)]
    fn respond(&self, squares: &[Lanes; 3]) -> PrincipalResponse {
        let (mut inverse, mut i1, mut i2) = ([[0.0; LANES]; 3], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let [a, b, c] = [0, 1, 2].inline_map(|k| squares[k][l]);
            let [d, e, f] = [a, b, c].inline_map(|x| 1.0 / x);
            (inverse[0][l], inverse[1][l], inverse[2][l]) = (d, e, f);
            (i1[l], i2[l]) = (a + b + c, d + e + f);
        }
        let InvariantDerivatives { first: [u1, u2], second: [u11, u12, u22] } = self.derivatives(&i1, &i2);
        let mut answer = PrincipalResponse::NOTHING;
        for k in 0..3 {
            for l in 0..LANES {
                let (x, y, i1, i2) = (squares[k][l], inverse[k][l], i1[l], i2[l]);
                // Derivatives of the invariants with respect to one logarithmic stretch at constant volume: a third of
                // its change is subtracted from each stretch.
                let (a, b) = (2.0 * (x - i1 * (1.0 / 3.0)), 2.0 * (i2 * (1.0 / 3.0) - y));
                let (aa, bb) = (4.0 / 9.0 * (3.0 * x + i1), 4.0 / 9.0 * (3.0 * y + i2));
                answer.stress[k][l] = u1[l] * a + u2[l] * b;
                answer.stiffness[k][l] =
                    (u11[l] * a * a + 2.0 * u12[l] * a * b + u22[l] * b * b) + (u1[l] * aa + u2[l] * bb);
            }
        }
        answer
    }
}

/// Ogden energy Σ 2 mu_i/alpha_i² (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3).
#[derive(Clone, Debug, PartialEq)]
pub struct OgdenEnergy {
    /// Pairs mu_i, alpha_i.
    pub terms: Vec<[f64; 2]>,
}

impl StrainEnergy for OgdenEnergy {
    /// Equation (6.11).
    #[inline(always)]
    fn respond(&self, squares: &[Lanes; 3]) -> PrincipalResponse {
        let logarithms = [ln(&squares[0]), ln(&squares[1]), ln(&squares[2])];
        let mut answer = PrincipalResponse::NOTHING;
        for &[mu, alpha] in &self.terms {
            let power = [0, 1, 2].inline_map(|k| {
                let mut exponent = logarithms[k];
                for l in 0..LANES {
                    exponent[l] *= 0.5 * alpha;
                }
                exp(&exponent)
            });
            let (push, pull) = (2.0 * mu / alpha, 2.0 / 3.0 * mu);
            for l in 0..LANES {
                let third = (power[0][l] + power[1][l] + power[2][l]) * (1.0 / 3.0);
                for k in 0..3 {
                    answer.stress[k][l] += push * (power[k][l] - third);
                    answer.stiffness[k][l] += pull * (power[k][l] + third);
                }
            }
        }
        answer
    }
}

/// Volumetric strain energy Σ (J - 1)^(2i)/D_i.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumetricEnergy {
    /// 1/D_i.
    pub inverse: Vec<f64>,
}

impl VolumetricEnergy {
    pub fn initial(&self) -> f64 {
        self.inverse.first().map_or(0.0, |inverse| 2.0 * inverse)
    }

    /// Returns the first and second derivative with respect to J.
    #[inline(always)]
    pub fn respond(&self, j: &Lanes) -> [Lanes; 2] {
        let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
        // `power` is (J - 1)^(2i - 2), `order` is 2i.
        let (mut power, mut order) = ([1.0; LANES], 2.0);
        for inverse in &self.inverse {
            for l in 0..LANES {
                let growth = j[l] - 1.0;
                first[l] += order * inverse * power[l] * growth;
                second[l] += order * (order - 1.0) * inverse * power[l];
                power[l] *= growth * growth;
            }
            order += 2.0;
        }
        [first, second]
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, OgdenEnergy, PolynomialEnergy, StrainEnergy, VolumetricEnergy};

    /// Returns squared isochoric stretches: a third of the sum is subtracted from each logarithm.
    fn squares(logarithms: [f64; 3]) -> [f64; 3] {
        let third = logarithms.iter().sum::<f64>() / 3.0;
        logarithms.map(|l| (2.0 * (l - third)).exp())
    }

    /// Compares the derivatives with difference quotients of the energy.
    fn agrees(law: &impl StrainEnergy, energy: impl Fn([f64; 3]) -> f64) {
        for at in [[0.0, 0.0, 0.0], [0.6, -0.2, 0.1], [-0.4, 0.5, -0.9]] {
            let answer = law.respond(&squares(at).map(|square| [square; LANES]));
            let [stress, stiffness] = [answer.stress, answer.stiffness].map(|list| list.map(|lanes| lanes[LANES - 1]));
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
    fn derivatives_match_difference_quotients() {
        let terms = vec![(0.5, 1, 0), (0.2, 0, 1), (-0.02, 2, 0), (0.01, 1, 1), (0.03, 0, 2), (0.004, 3, 0)];
        let energy_terms = terms.clone();
        agrees(&PolynomialEnergy { terms }, |s| {
            let (x, y) = (s.iter().sum::<f64>() - 3.0, s.iter().map(|x| 1.0 / x).sum::<f64>() - 3.0);
            energy_terms.iter().map(|&(c, i, j)| c * x.powi(i as i32) * y.powi(j as i32)).sum()
        });
        let terms = vec![[0.6, 1.3], [0.01, 5.0], [-0.1, -2.0]];
        let energy_terms = terms.clone();
        agrees(&OgdenEnergy { terms }, |s| {
            energy_terms
                .iter()
                .map(|[mu, a]| 2.0 * mu / (a * a) * (s.iter().map(|x| x.powf(a / 2.0)).sum::<f64>() - 3.0))
                .sum()
        });
        let volume = VolumetricEnergy { inverse: vec![10.0, 3.0] };
        let energy = |j: f64| 10.0 * (j - 1.0).powi(2) + 3.0 * (j - 1.0).powi(4);
        let [first, second] = volume.respond(&[1.3; LANES]).map(|lanes| lanes[0]);
        assert!((first - (energy(1.3 + 1e-6) - energy(1.3 - 1e-6)) / 2e-6).abs() < 1e-6);
        assert!((second - (20.0 + 36.0 * 0.09)).abs() < 1e-12 && volume.initial() == 20.0);
    }
}
