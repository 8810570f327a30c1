//! The rise of temperature that plastic work brings.
//! Never here: how much work there is.

use super::hardening::Table;

/// Heat from plastic work that stays where it is made (ABAQUS Analysis User's Guide 6.5.4, "Adiabatic analysis"):
/// `rho c(T) dT = eta dW`.
#[derive(Clone, Debug)]
pub enum Heating {
    None,
    /// Rise of temperature for a work a volume: eta / (rho c).
    Constant(f64),
    /// The specific heat depends on the temperature.
    Over {
        /// eta / rho: heat a mass for a work a volume.
        heat: f64,
        /// Specific heat over temperature, linear between rows and constant beyond the ends.
        capacity: Table,
    },
}

impl Heating {
    pub fn is_none(&self) -> bool {
        matches!(self, Heating::None)
    }

    /// Rise from a temperature by a work a volume, the product of some factors; with the specific heat of the middle of the
    /// rise, to second order.
    #[inline]
    pub fn rise<const N: usize>(&self, temperature: f64, work: [f64; N]) -> f64 {
        match self {
            Heating::None => 0.0,
            Heating::Constant(per_work) => work.iter().fold(*per_work, |product, factor| product * factor),
            Heating::Over { heat, capacity } => {
                let heat = work.iter().fold(*heat, |product, factor| product * factor);
                let half = 0.5 * heat / capacity.value(temperature);
                heat / capacity.value(temperature + half)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Heating, Table};

    /// c = 100 + 2 T takes the heat 100 (T - T0) + T^2 - T0^2.
    #[test]
    fn heat_goes_into_a_capacity_that_grows() {
        let heating = Heating::Over { heat: 1.0, capacity: Table { rows: vec![[100.0, 0.0], [300.0, 100.0]] } };
        let mut temperature = 10.0;
        for _ in 0..1000 {
            temperature += heating.rise(temperature, [2.0, 3.0]);
        }
        let taken = 100.0 * (temperature - 10.0) + temperature * temperature - 100.0;
        assert!((taken / 6000.0 - 1.0).abs() < 1e-6, "{taken}");
        assert_eq!(Heating::None.rise(3.0, [4.0]), 0.0);
        assert_eq!(Heating::Constant(0.5).rise(3.0, [4.0]), 2.0);
    }
}
