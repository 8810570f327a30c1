//! Checks of the unit system of a deck: all its materials, known metals and gravity must be plausible in one system.

use super::finding::{used_materials, warn_about};
use crate::model::{
    DeckUnits, EosKind, LoadKind, MaterialDefinition, Model, PlasticityModel, SYSTEMS, UnitSystem, is_without_units,
    within,
};
use crate::plan::Report;

/// Ranges of density, kg/m3, and speed of sound sqrt(3 G/rho), m/s, of rubber, gels and tissue.
const SOFT_DENSITIES: [f64; 2] = [300.0, 3000.0];
const SOFT_SPEEDS: [f64; 2] = [0.3, 700.0];
/// Lower limit of the density, kg/m3, and upper limit of the speed of sound sqrt(E/rho), m/s, of materials with the plasticity
/// of von Mises: light wood and foams, and beryllium, which has 12 900.
const LEAST_METAL_DENSITY: f64 = 100.0;
const LARGEST_METAL_SPEED: f64 = 14e3;
/// Unit system of hydrocodes that is rare in decks of solids: GPa, g/cm3 and km/s.
const HYDROCODE: UnitSystem =
    UnitSystem { names: ["mm", "mg", "us"], factors: [1e-3, 1e-6, 1e-6], derived: ["kN", "GPa", "J"] };
/// Gravity, m/s2, and the relative tolerance by which a value is recognised.
const GRAVITY: f64 = 9.81;
const GRAVITY_TOLERANCE: f64 = 0.005;

/// Range of the density of steel in which there is no other elastic solid, with or without plasticity, kg/m3.
const STEEL_DENSITIES: [f64; 2] = [7800.0, 7950.0];

/// A metal that its density identifies: no other technical metal has a density in this range.
struct Metal {
    name: &'static str,
    /// Range of the density, kg/m3.
    densities: [f64; 2],
    /// Range of Young's modulus, Pa, of all metals with this density, with a margin.
    moduli: [f64; 2],
    /// Lowest temperature at which an alloy of this metal begins to melt, K.
    solidus: f64,
}

/// Metals (ASM Metals Handbook; Ashby, Materials Selection in Mechanical Design, appendix A). Nickel, bronze and cobalt have
/// the density of copper.
const METALS: [Metal; 5] = [
    Metal { name: "aluminium", densities: [2640.0, 2850.0], moduli: [50e9, 100e9], solidus: 720.0 },
    Metal { name: "titanium", densities: [4400.0, 4520.0], moduli: [75e9, 135e9], solidus: 1800.0 },
    Metal { name: "steel", densities: [7750.0, 8050.0], moduli: [140e9, 260e9], solidus: 1580.0 },
    Metal { name: "copper", densities: [8900.0, 8970.0], moduli: [80e9, 240e9], solidus: 1200.0 },
    Metal { name: "lead", densities: [11_250.0, 11_400.0], moduli: [8e9, 30e9], solidus: 500.0 },
];

/// Density and stiffness of a material, in the units of the deck.
struct Stiffness<'m> {
    material: &'m MaterialDefinition,
    density: f64,
    modulus: f64,
    is_soft: bool,
}

impl Stiffness<'_> {
    fn new(material: &MaterialDefinition) -> Option<Stiffness<'_>> {
        let density = material.density.filter(|_| material.user.material.is_none())?;
        let rubber = material.hyperelastic.as_ref().map(|law| 3.0 * law.shape.shear()).filter(|modulus| *modulus > 0.0);
        let is_solid = matches!(material.eos.as_ref().map(|eos| &eos.kind), Some(EosKind::UsUp(_)));
        let bulk = material.bulk_modulus(None).filter(|_| is_solid && material.compaction.is_none());
        let modulus = rubber.or(material.elastic.map(|[modulus, _]| modulus)).or(bulk)?;
        Some(Stiffness { material, density, modulus, is_soft: rubber.is_some() })
    }

    fn fits(&self, system: &UnitSystem) -> bool {
        let speed = system.speed((self.modulus / self.density).sqrt());
        let density = system.density(self.density);
        if !self.is_soft {
            let is_dense = !self.is_metallic() || density >= LEAST_METAL_DENSITY && speed <= LARGEST_METAL_SPEED;
            return is_dense && system.fits(self.density, self.modulus);
        }
        within(density, SOFT_DENSITIES) && within(speed, SOFT_SPEEDS)
    }

    /// Returns whether the material has the plasticity of metals: of von Mises, over the modulus of *ELASTIC.
    fn is_metallic(&self) -> bool {
        let plastic = &self.material.plastic;
        let is_mises = matches!(plastic, Some(PlasticityModel::JohnsonCook(_) | PlasticityModel::Tabular(_)));
        is_mises && self.material.elastic.is_some()
    }

    /// Returns the metal of this density in a unit system; `None` if it is not a metal.
    fn metal(&self, system: &UnitSystem) -> Option<&'static Metal> {
        let is_metal = self.is_metallic();
        let density = system.density(self.density);
        let is_steel = within(density, STEEL_DENSITIES);
        let known = METALS.iter().find(|metal| within(density, metal.densities));
        known.filter(|_| self.material.elastic.is_some() && (is_metal || is_steel))
    }

    /// Returns whether the modulus is one that no metal of this density has.
    fn contradicts(&self, system: &UnitSystem) -> bool {
        self.metal(system).is_some_and(|metal| !within(system.stress(self.modulus), metal.moduli))
    }
}

/// Warns if the materials, and gravity, are not plausible in one of the usual unit systems, or in that of `*UNITS`.
/// Materials that fit none are reported by `plausibility::unit_warning`.
pub fn check_unit_systems(model: &Model, report: &mut Report) {
    let values: Vec<Stiffness<'_>> =
        used_materials(model).filter_map(|(_, material)| Stiffness::new(material)).collect();
    let units = model.settings.units.as_ref();
    let known = units.and_then(DeckUnits::system);
    if units.is_some() && known.is_none() || known.is_none() && values.iter().any(|v| is_without_units(v.density)) {
        return;
    }
    let mut systems: Vec<&UnitSystem> =
        SYSTEMS.iter().chain([&HYDROCODE]).filter(|system| known.is_none_or(|k| k == *system)).collect();
    let mut previous: Option<&Stiffness<'_>> = None;
    for value in &values {
        let all: Vec<&UnitSystem> = systems.clone();
        systems.retain(|system| value.fits(system));
        if systems.is_empty() {
            return report_unfit(value, previous.filter(|_| SYSTEMS.iter().any(|s| value.fits(s))), report);
        }
        let fitting = systems.clone();
        systems.retain(|system| !value.contradicts(system));
        if systems.is_empty() {
            return report_metal(value, fitting.first().or(all.first()).copied(), report);
        }
        previous = Some(value);
    }
    values.iter().for_each(|value| check_melting(model, value, &systems, report));
    if !values.is_empty() {
        check_gravity(model, &systems, report);
    }
}

/// Reports a material that fits no unit system of the materials before it.
fn report_unfit(value: &Stiffness<'_>, previous: Option<&Stiffness<'_>>, report: &mut Report) {
    let name = &value.material.name;
    let [density, modulus] = [value.density, value.modulus];
    let help = "use one unit system: steel has 7850 and 2.1e11 in m, kg, s, and 7.85e-9 and 2.1e5 in mm, t, s";
    let place = (value.material.span, "this material");
    if let Some(other) = previous {
        let message = format!(
            "density and modulus of `{name}` ({density:e}, {modulus:e}) and of `{}` ({:e}, {:e}) are not plausible in one unit \
             system",
            other.material.name, other.density, other.modulus
        );
        warn_about("P119", message, place, help, report);
    } else if value.material.elastic.is_none() || SYSTEMS.iter().any(|system| system.fits(density, modulus)) {
        let message = format!(
            "density {density:e} and modulus {modulus:e} of `{name}` (wave speed {:.3e}) are not plausible in any usual unit system",
            (modulus / density).sqrt()
        );
        warn_about("P119", message, place, help, report);
    }
}

fn report_metal(value: &Stiffness<'_>, system: Option<&UnitSystem>, report: &mut Report) {
    let Some((system, metal)) = system.and_then(|system| Some((system, value.metal(system)?))) else { return };
    let [from, to] = metal.moduli.map(|modulus| modulus / system.stress(1.0));
    let message = format!(
        "`{}` has the density of {} in {} ({:e}), and a Young's modulus of {:e}, which is outside {from:.2e} to {to:.2e}",
        value.material.name,
        metal.name,
        system.words(),
        value.density,
        value.modulus
    );
    let help = "check both: they belong to different metals, or one has a wrong power of ten";
    warn_about("P140", message, (value.material.span, "this material"), help, report);
}

/// Warns of a melting temperature below that of all alloys of the metal, on an absolute scale.
fn check_melting(model: &Model, value: &Stiffness<'_>, systems: &[&UnitSystem], report: &mut Report) {
    let Some(PlasticityModel::JohnsonCook([.., melting, transition])) = value.material.plastic else { return };
    let is_kelvin = within(transition, ROOM_IN_KELVIN);
    let metals: Option<Vec<&Metal>> = systems.iter().map(|system| value.metal(system)).collect();
    let Some(metal) = metals.as_deref().and_then(|metals| metals.first()).filter(|_| is_kelvin) else { return };
    if melting >= metal.solidus || melting <= transition || model.settings.absolute_zero != 0.0 {
        return;
    }
    let message = format!(
        "the melting temperature {melting} of `{}` is below {} K, at which alloys of {} begin to melt; the transition temperature \
         {transition} is in kelvin",
        value.material.name, metal.solidus, metal.name
    );
    let help = "give both temperatures in kelvin, or both in deg C";
    warn_about("P141", message, (value.material.span, "this material"), help, report);
}

/// Warns of gravity in a unit system in which the materials are not plausible.
fn check_gravity(model: &Model, systems: &[&UnitSystem], report: &mut Report) {
    let acceleration = |system: &UnitSystem| GRAVITY * system.factors[2].powi(2) / system.factors[0];
    let is_gravity =
        |value: f64, system: &UnitSystem| (value.abs() / acceleration(system) - 1.0).abs() < GRAVITY_TOLERANCE;
    for load in model.steps.iter().flat_map(|step| &step.loads) {
        if !matches!(load.kind, LoadKind::Gravity { .. }) || systems.iter().any(|s| is_gravity(load.magnitude, s)) {
            continue;
        }
        let Some(other) = SYSTEMS.iter().find(|system| is_gravity(load.magnitude, system)) else { continue };
        let message = format!(
            "the acceleration {} is gravity in {}; the materials are plausible in {}, where gravity is {:.4e}",
            load.magnitude,
            other.words(),
            systems[0].words(),
            acceleration(systems[0])
        );
        return warn_about(
            "P119",
            message,
            (load.span, "this load"),
            "give GRAV in the units of the materials",
            report,
        );
    }
}

/// Room temperature in kelvin, with a margin.
pub const ROOM_IN_KELVIN: [f64; 2] = [283.0, 308.0];
