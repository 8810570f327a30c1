//! Closed sums over a ring inside one layer, without friction: of the pressure, its cosine and sine terms, and the slope of
//! the force over the speed. The normal velocity is a cosine about one angle, so all integrands are polynomials in it.

use std::f64::consts::PI;

use super::rings::{RingHarmonics, RingSlope};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::lanes::inline_from_fn;

/// Mean over a ring of the pressure p, p cos and p sin.
pub(super) type PressureMeans = [f64; 3];
/// Integrals of the powers 0 to 4 of the cosine over an arc.
type CosineMoments = [f64; 5];

/// Returns the means for a ring that moves into the layer along its whole circumference. Equation (13.5).
#[inline(always)]
pub(super) fn whole_ring(around: &RingHarmonics, law: &CavityResistance) -> PressureMeans {
    let RingHarmonics { mean, cosine, sine, .. } = *around;
    let level = law.c0 + mean * (law.c1 + law.c2 * mean) + 0.5 * law.c2 * (cosine * cosine + sine * sine);
    let slope = 0.5 * law.c1 + law.c2 * mean;
    [level, slope * cosine, slope * sine]
}

/// Returns the means for a ring of which an arc moves into the layer, with the regularisation (13.6) of the pressure below
/// the speed `onset`, and the slope over the speed. `swing` is the amplitude of the normal velocity.
pub(super) fn part_of_ring(
    around: &RingHarmonics,
    swing: f64,
    law: &CavityResistance,
    onset: f64,
) -> (PressureMeans, RingSlope) {
    let RingHarmonics { mean, cosine, sine, .. } = *around;
    let moving = moments_above(-mean, swing);
    let full = moments_above(onset - mean, swing);
    let partial: CosineMoments = inline_from_fn(|k| moving[k] - full[k]);
    // Pressure as a polynomial in the cosine; below the onset it is multiplied by (mean + swing cos) / onset.
    let p = [law.c0 + mean * (law.c1 + law.c2 * mean), swing * (law.c1 + 2.0 * law.c2 * mean), law.c2 * swing * swing];
    let [rise, growth] = [mean / onset, swing / onset];
    let reduced = [p[0] * rise, p[0] * growth + p[1] * rise, p[1] * growth + p[2] * rise, p[2] * growth];
    let sum = |coefficients: &[f64], moments: &[f64]| coefficients.iter().zip(moments).map(|(c, m)| c * m).sum::<f64>();
    let per = 1.0 / (2.0 * PI);
    let level = per * (sum(&p, &full) + sum(&reduced, &partial));
    let along = per * (sum(&p, &full[1..]) + sum(&reduced, &partial[1..]));
    let slope = per / onset * sum(&p, &partial);
    let second_harmonic = per / onset * (2.0 * sum(&p, &partial[2..])) - slope;
    let direction = if swing > 0.0 { [cosine / swing, sine / swing] } else { [1.0, 0.0] };
    let [c, s] = direction;
    let twice = [c * c - s * s, 2.0 * c * s];
    let slope = RingSlope { mean: slope, second_harmonic: [second_harmonic * twice[0], second_harmonic * twice[1]] };
    ([level, along * c, along * s], slope)
}

/// Returns the moments of the arc on which `swing cos` is above a limit.
fn moments_above(limit: f64, swing: f64) -> CosineMoments {
    if limit >= swing {
        return [0.0; 5];
    }
    if limit <= -swing {
        return [2.0 * PI, 0.0, PI, 0.0, 0.75 * PI];
    }
    let cosine = limit / swing;
    let (angle, sine) = (libm::acos(cosine), ((1.0 - cosine) * (1.0 + cosine)).sqrt());
    // The integral of cos^k from -a to a is (2 cos^(k-1) a sin a + (k - 1) times that of cos^(k-2)) / k.
    let (zeroth, first) = (2.0 * angle, 2.0 * sine);
    let second = cosine * sine + angle;
    let square = cosine * cosine;
    let third = 2.0 / 3.0 * (square * sine + first);
    [zeroth, first, second, third, 0.5 * square * cosine * sine + 0.75 * second]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: CavityResistance = CavityResistance { c0: 1.4e9, c1: 2.6e5, c2: 2700.0 };

    /// Sums over 400 000 points around the ring: pressure, cosine and sine terms, and the slope with its second harmonic.
    fn by_points([mean, cosine, sine]: [f64; 3], onset: f64) -> [f64; 6] {
        let count = 400_000;
        let mut sums = [0.0; 6];
        for point in 0..count {
            let angle = 2.0 * PI * (f64::from(point) + 0.5) / f64::from(count);
            let speed = mean + cosine * angle.cos() + sine * angle.sin();
            if speed <= 0.0 {
                continue;
            }
            let pressure = LAW.stress(speed) * (speed / onset).min(1.0);
            let slope = if speed < onset { LAW.stress(speed) / onset } else { 0.0 };
            let terms = [
                pressure,
                pressure * angle.cos(),
                pressure * angle.sin(),
                slope,
                slope * (2.0 * angle).cos(),
                slope * (2.0 * angle).sin(),
            ];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term / f64::from(count));
        }
        sums
    }

    #[test]
    fn closed_sums_over_an_arc_match_a_fine_sum_over_points() {
        let onset = 1.25;
        let velocities = [[0.0, 0.3, -0.2], [0.4, 0.0, 0.9], [-3.0, 4.0, 2.0], [100.0, -180.0, 60.0], [0.6, 0.1, 0.0]];
        for velocity in velocities {
            let [mean, cosine, sine] = velocity;
            let around = RingHarmonics { mean, cosine, sine, height: 0.0, rise: [0.0; 2] };
            let (means, slope) = part_of_ring(&around, cosine.hypot(sine), &LAW, onset);
            let closed = [means[0], means[1], means[2], slope.mean, slope.second_harmonic[0], slope.second_harmonic[1]];
            let expected = by_points(velocity, onset);
            for (value, sum) in closed.iter().zip(expected) {
                assert!((value - sum).abs() < 2e-5 * expected[0].max(LAW.c0), "{velocity:?}: {closed:?} {expected:?}");
            }
        }
    }

    #[test]
    fn whole_ring_above_the_onset_is_the_limit_of_an_arc() {
        let around = RingHarmonics { mean: 50.0, cosine: 3.0, sine: 4.0, height: 0.0, rise: [0.0; 2] };
        let (means, slope) = part_of_ring(&around, 5.0, &LAW, 1.0);
        for (value, expected) in means.iter().zip(whole_ring(&around, &LAW)) {
            assert!((value - expected).abs() < 1e-14 * LAW.c0, "{means:?}");
        }
        assert_eq!(slope.mean, 0.0);
    }
}
