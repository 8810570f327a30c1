//! Units: their names, which only name axes and tables, and the systems of units that constants of a solid may belong to by their
//! look.
//! Never here: conversion; the program computes in the deck's units, whatever they are.

use serde::{Deserialize, Serialize};

/// Names of the units of a deck.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Units {
    /// Length.
    pub length: String,
    /// Mass.
    pub mass: String,
    /// Time.
    pub time: String,
    /// Temperature.
    pub temperature: String,
}

/// A consistent system of units, by what its units are in kg, m and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct System {
    /// Length, mass and time by name.
    pub names: [&'static str; 3],
    /// The same in m, kg and s.
    pub factors: [f64; 3],
    /// Force, stress and energy by name.
    pub derived: [&'static str; 3],
}

const fn system(names: [&'static str; 3], factors: [f64; 3], derived: [&'static str; 3]) -> System {
    System { names, factors, derived }
}

/// Systems that are in use.
pub const SYSTEMS: [System; 8] = [
    system(["m", "kg", "s"], [1.0, 1.0, 1.0], ["N", "Pa", "J"]),
    system(["mm", "t", "s"], [1e-3, 1e3, 1.0], ["N", "MPa", "mJ"]),
    system(["mm", "kg", "ms"], [1e-3, 1.0, 1e-3], ["kN", "GPa", "J"]),
    system(["mm", "g", "ms"], [1e-3, 1e-3, 1e-3], ["N", "MPa", "mJ"]),
    system(["mm", "kg", "s"], [1e-3, 1.0, 1.0], ["mN", "kPa", "uJ"]),
    system(["cm", "g", "us"], [1e-2, 1e-3, 1e-6], ["1e7 N", "Mbar", "1e5 J"]),
    system(["cm", "g", "s"], [1e-2, 1e-3, 1.0], ["dyn", "Ba", "erg"]),
    system(["in", "lbf s2/in", "s"], [0.0254, 175.126_8, 1.0], ["lbf", "psi", "in lbf"]),
];

/// Densities of solids, kg/m3, foams and platinum included; and speeds of sound in them, m/s.
const DENSITIES: [f64; 2] = [0.5, 25e3];
const SPEEDS: [f64; 2] = [20.0, 25e3];
/// Denser than this is no foam, soil or rubber: metals and stone, in which sound is faster.
const DENSE: f64 = 3000.0;
const DENSE_SPEED: f64 = 500.0;

impl System {
    /// The density in kg/m3.
    pub fn density(&self, value: f64) -> f64 {
        let [length, mass, _] = self.factors;
        value * mass / length.powi(3)
    }

    /// The speed in m/s.
    pub fn speed(&self, value: f64) -> f64 {
        value * self.factors[0] / self.factors[2]
    }

    /// Whether a density is one of solids.
    pub fn has_density(&self, density: f64) -> bool {
        within(self.density(density), DENSITIES)
    }

    /// Whether a density and a modulus may be those of a solid: the speed of sound says.
    pub fn fits(&self, density: f64, modulus: f64) -> bool {
        let speed = self.speed((modulus / density).sqrt());
        let dense = self.density(density) > DENSE;
        self.has_density(density) && within(speed, SPEEDS) && (!dense || speed > DENSE_SPEED)
    }

    /// Its names as `*UNITS` has them.
    pub fn words(&self) -> String {
        self.names.join(", ")
    }
}

/// Whether a density is one of decks without units: a single digit near one.
pub fn is_without_units(density: f64) -> bool {
    let digit = format!("{density:e}");
    let single = digit.split_once('e').is_some_and(|(mantissa, _)| mantissa.len() == 1);
    single && (0.01..=100.0).contains(&density)
}

fn within(value: f64, [from, to]: [f64; 2]) -> bool {
    (from..=to).contains(&value)
}

impl Units {
    /// The system that the names belong to, if it is one of those in use.
    pub fn system(&self) -> Option<&'static System> {
        let same = |name: &str, word: &str| {
            let word = word.to_lowercase().replace('µ', "u").replace("tonne", "t");
            name == word || name == "s" && word == "sec" || name == "t" && word == "mg"
        };
        SYSTEMS.iter().find(|system| {
            let [length, mass, time] = system.names;
            same(length, &self.length) && same(mass, &self.mass) && same(time, &self.time)
        })
    }

    /// Name of a unit by powers of length, mass, time and temperature, as `kg/m3`.
    pub fn name(&self, powers: [i32; 4]) -> String {
        let derived = self.system().and_then(|system| {
            let at = [[1, 1, -2, 0], [-1, 1, -2, 0], [2, 1, -2, 0]].iter().position(|p| *p == powers)?;
            Some(system.derived[at].to_owned())
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
    use super::{SYSTEMS, Units, is_without_units};

    /// Steel, rubber, foam, lead, concrete and diamond in every system: each fits its own; and steel whose modulus is of another
    /// system fits none.
    #[test]
    fn solids_fit_their_system_and_mixtures_none() {
        let solids =
            [[7850.0, 2.1e11], [1100.0, 3e6], [60.0, 4e6], [11_340.0, 1.6e10], [2400.0, 3e10], [3500.0, 1.05e12]];
        for system in SYSTEMS {
            let [length, mass, time] = system.factors;
            for [density, modulus] in solids {
                let here = [density * length.powi(3) / mass, modulus * length * time * time / mass];
                assert!(system.fits(here[0], here[1]), "{system:?} {density}");
            }
        }
        for [density, modulus] in [[7850.0, 210e3], [7.85e-9, 2.1e11], [7850.0, 210.0]] {
            let found: Vec<_> = SYSTEMS.iter().filter(|s| s.fits(density, modulus)).collect();
            assert!(found.is_empty(), "{density} {modulus}: {found:?}");
        }
        assert_eq!(
            [1.0, 0.5, 20.0, 7.85, 7850.0, 1000.0].map(is_without_units),
            [true, true, true, false, false, false]
        );
    }

    #[test]
    fn names_of_units_follow_from_those_of_three() {
        let units = |l: &str, m: &str, t: &str| Units {
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
