//! Temperature rise by plastic work.

use super::hardening::LinearTable;

/// Adiabatic heating by plastic work (ABAQUS Analysis User's Guide 6.5.4, "Adiabatic analysis"): `rho c(T) dT = eta
/// dW`.
#[derive(Clone, Debug)]
pub enum PlasticHeating {
    None,
    /// Temperature rise per work and volume: eta / (rho c).
    Constant(f64),
    /// Heating with a specific heat that depends on the temperature.
    Over {
        /// eta / rho: heat per mass, for a work per volume.
        heat: f64,
        /// Specific heat over temperature, with linear interpolation, constant beyond the ends.
        capacity: LinearTable,
    },
}

impl PlasticHeating {
    pub fn is_none(&self) -> bool {
        matches!(self, PlasticHeating::None)
    }

    /// Returns the temperature rise from `temperature` by a work per volume, given as a product of factors. The
    /// specific heat is that at the middle of the rise, which is second-order accurate. Equation (6.6).
    #[inline]
    pub fn rise<const N: usize>(&self, temperature: f64, work: [f64; N]) -> f64 {
        match self {
            PlasticHeating::None => 0.0,
            PlasticHeating::Constant(per_work) => work.iter().fold(*per_work, |product, factor| product * factor),
            PlasticHeating::Over { heat, capacity } => {
                let heat = work.iter().fold(*heat, |product, factor| product * factor);
                let half = 0.5 * heat / capacity.value(temperature);
                heat / capacity.value(temperature + half)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LinearTable, PlasticHeating};

    /// c = 100 + 2 T absorbs the heat 100 (T - T0) + T² - T0².
    #[test]
    fn temperature_rise_follows_a_linear_specific_heat() {
        let heating =
            PlasticHeating::Over { heat: 1.0, capacity: LinearTable { rows: vec![[100.0, 0.0], [300.0, 100.0]] } };
        let mut temperature = 10.0;
        for _ in 0..1000 {
            temperature += heating.rise(temperature, [2.0, 3.0]);
        }
        let taken = 100.0 * (temperature - 10.0) + temperature * temperature - 100.0;
        assert!((taken / 6000.0 - 1.0).abs() < 1e-6, "{taken}");
        assert_eq!(PlasticHeating::None.rise(3.0, [4.0]), 0.0);
        assert_eq!(PlasticHeating::Constant(0.5).rise(3.0, [4.0]), 2.0);
    }
}
