//! Damage of an interface as a function of the effective separation δ along a ray, and the energy that it dissipates:
//! the integral of ½ δ² dD, an energy per area over the stiffness of the ray.

/// Bisections that resolve a separation to rounding.
const BISECTIONS: usize = 80;
/// Multiple of the energy after initiation at which exponential softening has ended to rounding.
const ENDED: f64 = 40.0;

/// Damage along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageEnvelope<'a> {
    /// Effective separation δ0 at initiation.
    pub onset: f64,
    pub shape: EnvelopeShape<'a>,
}

/// Form of the softening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvelopeShape<'a> {
    /// Traction that decreases linearly to zero at this separation.
    Linear(f64),
    /// Traction that decreases as 1 - (1 - e^(-αx))/(1 - e^(-α)), where x goes from 0 at initiation to 1 at this
    /// separation; α is the second number.
    Exponential(f64, f64),
    /// 1 - D = e^(-(δ² - δ0²)/(2 G)), where G is this energy over the stiffness: dD = T dδ/(Gc - G0).
    EnergyExponential(f64),
    /// Rows of damage and separation after initiation, linear between the rows and constant after the last.
    Tabular(&'a [[f64; 2]]),
}

impl DamageEnvelope<'_> {
    /// Returns the damage at an effective separation.
    pub fn damage(&self, separation: f64) -> f64 {
        if separation <= self.onset {
            return 0.0;
        }
        let onset = self.onset;
        match self.shape {
            EnvelopeShape::Linear(end) | EnvelopeShape::Exponential(end, _) if separation >= end => 1.0,
            EnvelopeShape::Linear(end) => end * (separation - onset) / (separation * (end - onset)),
            EnvelopeShape::Exponential(end, rate) => {
                let x = (separation - onset) / (end - onset);
                1.0 - onset / separation * (1.0 - libm::expm1(-rate * x) / libm::expm1(-rate))
            }
            EnvelopeShape::EnergyExponential(0.0) => 1.0,
            EnvelopeShape::EnergyExponential(energy) => {
                -libm::expm1(-0.5 * (separation - onset) * (separation + onset) / energy)
            }
            EnvelopeShape::Tabular(rows) => {
                let after = separation - onset;
                let next = rows.partition_point(|row| row[1] <= after);
                match (rows.get(next.wrapping_sub(1)), rows.get(next)) {
                    (Some(a), Some(b)) => a[0] + (b[0] - a[0]) * (after - a[1]) / (b[1] - a[1]),
                    (Some(row), None) => row[0],
                    _ => 0.0,
                }
            }
        }
    }

    /// Returns the integral of ½ δ² dD from initiation to a separation.
    pub fn dissipated(&self, separation: f64) -> f64 {
        if separation <= self.onset {
            return 0.0;
        }
        let onset = self.onset;
        let elastic = 0.5 * onset * onset;
        match self.shape {
            EnvelopeShape::Linear(end) | EnvelopeShape::Exponential(end, _) if end <= onset => elastic,
            EnvelopeShape::Linear(end) => 0.5 * onset * end * (separation.min(end) - onset) / (end - onset),
            EnvelopeShape::Exponential(end, rate) => {
                // The work along the envelope less the energy stored at its end.
                let reached = separation.min(end);
                let x = (reached - onset) / (end - onset);
                let integral = x - (x + libm::expm1(-rate * x) / rate) / -libm::expm1(-rate);
                elastic + onset * (end - onset) * integral - 0.5 * (1.0 - self.damage(reached)) * reached * reached
            }
            EnvelopeShape::EnergyExponential(0.0) => elastic,
            EnvelopeShape::EnergyExponential(energy) => {
                let ratio = 0.5 * (separation - onset) * (separation + onset) / energy;
                let lost = -libm::expm1(-ratio);
                elastic * lost + energy * (lost - ratio * libm::exp(-ratio))
            }
            EnvelopeShape::Tabular(rows) => {
                let cube = |x: f64| x * x * x;
                let part = |pair: &[[f64; 2]]| {
                    let (from, until) = (onset + pair[0][1], (onset + pair[1][1]).min(separation));
                    let slope = (pair[1][0] - pair[0][0]) / (pair[1][1] - pair[0][1]);
                    if until > from { slope * (cube(until) - cube(from)) / 6.0 } else { 0.0 }
                };
                rows.windows(2).map(part).sum()
            }
        }
    }

    /// Returns the separation at which the envelope reaches a damage above 0.
    pub fn separation_at(&self, damage: f64) -> f64 {
        let (mut low, mut high) = (self.onset, self.end());
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.damage(middle) < damage {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Returns a separation at which damage does not grow any more, to rounding.
    fn end(&self) -> f64 {
        match self.shape {
            EnvelopeShape::Linear(end) | EnvelopeShape::Exponential(end, _) => end,
            EnvelopeShape::EnergyExponential(energy) => (self.onset * self.onset + 2.0 * ENDED * energy).sqrt(),
            EnvelopeShape::Tabular(rows) => self.onset + rows.last().map_or(0.0, |row| row[1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DamageEnvelope, EnvelopeShape};

    const ROWS: &[[f64; 2]] = &[[0.0, 0.0], [0.7, 0.5], [0.8, 1.0], [1.0, 4.0]];

    fn envelopes() -> [DamageEnvelope<'static>; 4] {
        [
            EnvelopeShape::Linear(5.0),
            EnvelopeShape::Exponential(5.0, 2.5),
            EnvelopeShape::EnergyExponential(1.3),
            EnvelopeShape::Tabular(ROWS),
        ]
        .map(|shape| DamageEnvelope { onset: 1.0, shape })
    }

    #[test]
    fn dissipation_is_the_integral_of_the_damage() {
        for envelope in envelopes() {
            let (steps, mut sum) = (200_000, 0.0);
            let separation_of = |i: usize| 1.0 + 3.0 * i as f64 / steps as f64;
            for i in 0..steps {
                let middle = 0.5 * (separation_of(i) + separation_of(i + 1));
                sum +=
                    0.5 * middle * middle * (envelope.damage(separation_of(i + 1)) - envelope.damage(separation_of(i)));
            }
            let dissipated = envelope.dissipated(4.0);
            assert!((dissipated / sum - 1.0).abs() < 1e-9, "{envelope:?}: {dissipated} {sum}");
        }
    }

    #[test]
    fn separation_is_the_inverse_of_the_damage() {
        for envelope in envelopes() {
            for separation in [1.01, 1.4, 2.0, 3.7] {
                let inverse = envelope.separation_at(envelope.damage(separation));
                assert!((inverse - separation).abs() < 1e-12, "{envelope:?}: {inverse} {separation}");
            }
        }
    }
}
