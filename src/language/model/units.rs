//! Names of units, used for labels only, and detection of the unit system of material constants. The program computes
//! in the units of the deck and converts nothing.

use serde::{Deserialize, Serialize};

/// Names of the units of a deck (`*UNITS`).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeckUnits {
    /// Unit of length.
    pub length: String,
    /// Unit of mass.
    pub mass: String,
    /// Unit of time.
    pub time: String,
    /// Unit of temperature.
    pub temperature: String,
}

/// A consistent unit system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitSystem {
    /// Names of the units of length, mass and time.
    pub names: [&'static str; 3],
    /// These units in m, kg and s.
    pub factors: [f64; 3],
    /// Names of the units of force, stress and energy.
    pub derived: [&'static str; 3],
}

const fn system(names: [&'static str; 3], factors: [f64; 3], derived: [&'static str; 3]) -> UnitSystem {
    UnitSystem { names, factors, derived }
}

/// Unit systems in common use.
pub const SYSTEMS: [UnitSystem; 8] = [
    system(["m", "kg", "s"], [1.0, 1.0, 1.0], ["N", "Pa", "J"]),
    system(["mm", "t", "s"], [1e-3, 1e3, 1.0], ["N", "MPa", "mJ"]),
    system(["mm", "kg", "ms"], [1e-3, 1.0, 1e-3], ["kN", "GPa", "J"]),
    system(["mm", "g", "ms"], [1e-3, 1e-3, 1e-3], ["N", "MPa", "mJ"]),
    system(["mm", "kg", "s"], [1e-3, 1.0, 1.0], ["mN", "kPa", "uJ"]),
    system(["cm", "g", "us"], [1e-2, 1e-3, 1e-6], ["1e7 N", "Mbar", "1e5 J"]),
    system(["cm", "g", "s"], [1e-2, 1e-3, 1.0], ["dyn", "Ba", "erg"]),
    system(["in", "lbf s2/in", "s"], [0.0254, 175.126_8, 1.0], ["lbf", "psi", "in lbf"]),
];

/// Range of densities of solids from foam to platinum, kg/m3, and of their speeds of sound, m/s.
const DENSITIES: [f64; 2] = [0.5, 25e3];
const SPEEDS: [f64; 2] = [20.0, 25e3];
/// Density above which a solid is metal or stone, kg/m3, and their smallest speed of sound, m/s.
const DENSE: f64 = 3000.0;
const DENSE_SPEED: f64 = 500.0;
/// Range of the square root of yield stress over density, m/s: 0.1 MPa of loose soil gives 7, 5 GPa of a ceramic 1200.
const STRENGTH_SPEEDS: [f64; 2] = [1.0, 3000.0];
/// Density above which a target is neither soil nor concrete, kg/m3, and the least square root of its yield stress over its
/// density, m/s: soft lead of 5 MPa gives 21.
const DENSE_TARGET: f64 = 2500.0;
const DENSE_STRENGTH_SPEED: f64 = 15.0;

impl UnitSystem {
    /// Converts a density to kg/m3.
    pub fn density(&self, value: f64) -> f64 {
        let [length, mass, _] = self.factors;
        value * mass / length.powi(3)
    }

    /// Converts a speed to m/s.
    pub fn speed(&self, value: f64) -> f64 {
        value * self.factors[0] / self.factors[2]
    }

    /// Converts a stress to Pa.
    pub fn stress(&self, value: f64) -> f64 {
        value * self.density(1.0) * self.speed(1.0).powi(2)
    }

    /// Returns whether density and modulus are plausible for a solid, based on the speed of sound.
    pub fn fits(&self, density: f64, modulus: f64) -> bool {
        let speed = self.speed((modulus / density).sqrt());
        let density = self.density(density);
        within(density, DENSITIES) && within(speed, SPEEDS) && (density <= DENSE || speed > DENSE_SPEED)
    }

    /// Returns whether density and yield stress are plausible for a target.
    pub fn fits_target(&self, density: f64, yield_stress: f64) -> bool {
        let speed = self.speed((yield_stress / density).sqrt());
        let density = self.density(density);
        let is_strong_enough = density <= DENSE_TARGET || speed > DENSE_STRENGTH_SPEED;
        within(density, DENSITIES) && within(speed, STRENGTH_SPEEDS) && is_strong_enough
    }

    /// Returns the names in the form of `*UNITS`.
    pub fn words(&self) -> String {
        self.names.join(", ")
    }
}

/// Returns whether a density is probably dimensionless: one significant digit, from 0.01 to 100.
pub fn is_without_units(density: f64) -> bool {
    let digit = format!("{density:e}");
    let single = digit.split_once('e').is_some_and(|(mantissa, _)| mantissa.len() == 1);
    single && (0.01..=100.0).contains(&density)
}

/// Returns whether a value is in a closed range.
pub fn within(value: f64, [from, to]: [f64; 2]) -> bool {
    (from..=to).contains(&value)
}

impl DeckUnits {
    /// Returns the names in the form of `*UNITS`.
    pub fn words(&self) -> String {
        [&self.length, &self.mass, &self.time, &self.temperature].map(String::as_str).join(", ")
    }

    /// Returns the common unit system with these names; `None` for other combinations.
    pub fn system(&self) -> Option<&'static UnitSystem> {
        let same = |name: &str, word: &str| {
            let word = word.to_lowercase().replace('µ', "u").replace("tonne", "t");
            name == word || name == "s" && word == "sec" || name == "t" && word == "mg"
        };
        SYSTEMS.iter().find(|system| {
            let [length, mass, time] = system.names;
            same(length, &self.length) && same(mass, &self.mass) && same(time, &self.time)
        })
    }

    /// Returns the name of a derived unit, given the powers of length, mass, time and temperature, for example `kg/m3`.
    pub fn name(&self, powers: [i32; 4]) -> String {
        let derived = self.system().and_then(|system| {
            let index = [[1, 1, -2, 0], [-1, 1, -2, 0], [2, 1, -2, 0]].iter().position(|p| *p == powers)?;
            Some(system.derived[index].to_owned())
        });
        derived.unwrap_or_else(|| self.product(powers))
    }

    fn product(&self, powers: [i32; 4]) -> String {
        let names = [&self.length, &self.mass, &self.time, &self.temperature];
        let part = |sign: i32| {
            let parts = names.iter().zip(powers).filter(|(_, p)| p.signum() == sign).map(|(name, p)| match p.abs() {
                1 => (*name).clone(),
                power => format!("{name}{power}"),
            });
            parts.collect::<Vec<_>>().join(" ")
        };
        match (part(1), part(-1)) {
            (above, below) if below.is_empty() => above,
            (above, below) if above.is_empty() => format!("1/{below}"),
            (above, below) => format!("{above}/{below}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DeckUnits, SYSTEMS, is_without_units};

    /// Steel, rubber, foam, lead, concrete and diamond fit their own unit system. Steel with the modulus of another
    /// system fits none.
    #[test]
    fn solids_fit_their_system_and_mixtures_none() {
        let solids =
            [[7850.0, 2.1e11], [1100.0, 3e6], [60.0, 4e6], [11_340.0, 1.6e10], [2400.0, 3e10], [3500.0, 1.05e12]];
        for system in SYSTEMS {
            let [length, mass, time] = system.factors;
            for [density, modulus] in solids {
                let converted = [density * length.powi(3) / mass, modulus * length * time * time / mass];
                assert!(system.fits(converted[0], converted[1]), "{system:?} {density}");
            }
        }
        for [density, modulus] in [[7850.0, 210e3], [7.85e-9, 2.1e11], [7850.0, 210.0]] {
            let fitting: Vec<_> = SYSTEMS.iter().filter(|s| s.fits(density, modulus)).collect();
            assert!(fitting.is_empty(), "{density} {modulus}: {fitting:?}");
        }
        assert_eq!(
            [1.0, 0.5, 20.0, 7.85, 7850.0, 1000.0].map(is_without_units),
            [true, true, true, false, false, false]
        );
    }

    #[test]
    fn names_of_units_follow_from_those_of_three() {
        let units = |l: &str, m: &str, t: &str| DeckUnits {
            length: l.into(),
            mass: m.into(),
            time: t.into(),
            temperature: "K".into(),
        };
        let (si, odd) = (units("m", "kg", "s"), units("ft", "kg", "h"));
        let stress = [-1, 1, -2, 0];
        assert_eq!([si.name(stress), odd.name(stress)], ["Pa", "kg/ft h2"]);
        assert_eq!([si.name([-3, 1, 0, 0]), si.name([0, 0, 0, 0]), si.name([0, 0, -1, 0])], ["kg/m3", "", "1/s"]);
        assert_eq!(units("mm", "tonne", "sec").system().map(|s| s.derived[1]), Some("MPa"));
    }
}
