//! Checks of strength and failure: percent instead of strains, engineering stress, radians instead of degrees, rubber that is
//! too compressible, failure that no element can reach, temperatures on two scales.

use super::finding::Finding;
use super::unit_systems::ROOM_IN_KELVIN;
use crate::model::{
    DamageEvolution, MaterialDefinition, Model, PlasticityModel, RateDependence, StrainAtFailure, within,
};

/// Strain at the second row of a table from which strains are assumed to be in percent: local strains of metals at fracture
/// are below 3.
const PERCENT: f64 = 2.0;
/// Decrease of the yield stress below its largest value, as a fraction of that value, from which a curve softens.
const SOFTENING: f64 = 0.05;
/// Plastic strain above which no ductile metal stays intact, in uniaxial tension: copper of high purity breaks at 3 to 4
/// (true strain of the neck).
const LARGEST_FAILURE_STRAIN: f64 = 5.0;
/// Ratio of bulk to shear modulus below which a material is not rubber (Poisson's ratio below 0.13).
const LEAST_BULK_PER_SHEAR: f64 = 1.0;
/// Friction angle, or dilation angle of concrete, in degrees, up to which it is probably given in radians.
const RIGHT_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
/// Ratio of tensile to compressive strength above which a concrete is implausible: plain concrete has 0.05 to 0.15.
const TENSION_PER_COMPRESSION: f64 = 0.35;
/// Inelastic strain at the compressive strength of concrete above which strains are probably in percent: 0.001 to 0.02.
const CRUSHING_STRAIN: f64 = 0.05;
/// Ratio of the yield stress of a foam to its Young's modulus above which units differ: foams yield at strains of 0.01 to 0.1.
const FOAM_YIELD: f64 = 0.5;
/// Tensile cutoff over the yield stress below which units differ.
const LEAST_CUTOFF: f64 = 0.01;
/// Largest coefficient of thermal expansion of solids and liquids, 1/K.
const LARGEST_EXPANSION: f64 = 2e-3;
/// Rate D of the law of Cowper and Symonds below which the static yield stress, measured at 1e-4 1/s, would not exist; in the
/// unit of time of the deck, with a margin for milliseconds.
const LEAST_RATE: f64 = 1e-5;
/// Room temperature in deg C, with a margin.
const ROOM_IN_CELSIUS: [f64; 2] = [10.0, 35.0];

fn implausible(findings: &mut Vec<Finding>, message: String, help: &'static str) {
    findings.push(Finding { code: "P140", message, help });
}

/// Adds the findings on strength and failure of a material with its index.
pub fn check_strength(model: &Model, (index, material): (usize, &MaterialDefinition), findings: &mut Vec<Finding>) {
    check_hardening(material, findings);
    check_failure_strains(model, (index, material), findings);
    check_rubber(material, findings);
    check_foam(material, findings);
    check_geomaterials(material, findings);
    check_temperature_scales(model, material, findings);
    check_cutoff(material, findings);
    check_sensitivities(material, findings);
}

/// Checks the tensile cutoff of a metal: its spall strength is of the order of its yield stress, or above.
fn check_cutoff(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let name = &material.name;
    let Some(cutoff) = material.tensile_failure.as_ref().map(|failure| failure.cutoff) else { return };
    let elastic = material.elastic.map(|[modulus, ratio]| modulus / (3.0 - 6.0 * ratio));
    if let Some(bulk) = elastic.or(material.bulk_modulus(None)).filter(|bulk| cutoff > *bulk) {
        let message =
            format!("the tensile cutoff {cutoff:e} of `{name}` is above its bulk modulus {bulk:e}: it never acts");
        implausible(
            findings,
            message,
            "spall strengths of metals are 1 to 5 GPa; give the cutoff in the unit of the moduli",
        );
    }
    let stress = material.plastic.as_ref().and_then(PlasticityModel::initial_yield_stress).unwrap_or(0.0);
    if cutoff < LEAST_CUTOFF * stress {
        let message =
            format!("the tensile cutoff {cutoff:e} of `{name}` is {:.1e} of its yield stress", cutoff / stress);
        implausible(findings, message, "spall strengths of metals are above their yield stress; give both in one unit");
    }
}

/// Checks the coefficients of thermal expansion and of the rate dependence by Cowper and Symonds.
fn check_sensitivities(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let name = &material.name;
    let rows = material.thermal.expansion.iter().flat_map(|expansion| &expansion.rows);
    let largest = rows.map(|row| row[0].abs()).fold(0.0, f64::max);
    if largest > LARGEST_EXPANSION {
        let message =
            format!("the thermal expansion {largest:e} of `{name}` is above {LARGEST_EXPANSION:e} per degree");
        implausible(findings, message, "metals have 5e-6 to 3e-5, polymers 1e-4, liquids up to 1.5e-3");
    }
    if let Some(RateDependence::PowerLaw(rows)) = &material.rate
        && let Some([rate, ..]) = rows.iter().find(|row| row[0] < LEAST_RATE)
    {
        let message = format!(
            "D = {rate:e} of the rate dependence of `{name}` doubles the yield stress at rates below those of static tests"
        );
        implausible(findings, message, "the order of the constants is D, n: mild steel has 40.4 per second and 5");
    }
}

/// Checks a table of yield stress over plastic strain at one temperature.
fn check_hardening(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let Some(PlasticityModel::Tabular(rows)) = &material.plastic else { return };
    let name = &material.name;
    // A temperature that is not given is NaN.
    let is_isothermal = rows.iter().all(|row| row[2].to_bits() == rows[0][2].to_bits());
    let [_, second, .., last] = &rows[..] else { return };
    if !is_isothermal {
        return;
    }
    if rows.len() > 2 && second[1] >= PERCENT {
        let message = format!(
            "the plastic strains of `{name}` are {}, ..., {}: they are probably in percent",
            second[1], last[1]
        );
        implausible(
            findings,
            message,
            "the second value of a row of *PLASTIC is the true plastic strain, 0.02 for 2 %",
        );
    }
    let largest = rows.iter().map(|row| row[0]).fold(0.0, f64::max);
    if rows.len() > 2 && last[0] < (1.0 - SOFTENING) * largest && second[0] >= rows[0][0] {
        let message = format!(
            "the yield stress of `{name}` falls from {largest} to {} at plastic strain {}: the deformation concentrates in one \
             row of elements, and results depend on the mesh",
            last[0], last[1]
        );
        let help = "*PLASTIC takes true stress over true plastic strain, which does not fall after necking; give softening as *DAMAGE INITIATION with *DAMAGE EVOLUTION";
        implausible(findings, message, help);
    }
}

/// Checks strains at failure, and displacements after damage initiation against the size of elements.
fn check_failure_strains(model: &Model, (index, material): (usize, &MaterialDefinition), findings: &mut Vec<Finding>) {
    let name = &material.name;
    for criterion in &material.failures {
        let strain = match &criterion.strain {
            StrainAtFailure::Constant(strain) => Some(*strain),
            // A negative d3 has its own message.
            StrainAtFailure::JohnsonCook([d1, d2, d3, ..], _) => (*d3 >= 0.0).then(|| d1 + d2 * libm::exp(-d3 / 3.0)),
            StrainAtFailure::Ductile(rows) | StrainAtFailure::Shear(rows) => {
                rows.iter().map(|row| row[0]).reduce(f64::min)
            }
        };
        if let Some(strain) = strain.filter(|strain| *strain > LARGEST_FAILURE_STRAIN) {
            let message = format!("`{name}` fails at a plastic strain of {strain:.3} in tension: no metal reaches it");
            implausible(findings, message, "plastic strains at failure are fractions, 0.2 for 20 %");
        }
        if let StrainAtFailure::Ductile(rows) = &criterion.strain
            && increases_with_triaxiality(rows)
        {
            let message = format!(
                "the strain at damage initiation of `{name}` increases with the stress triaxiality: tension is stronger than compression"
            );
            implausible(findings, message, "the triaxiality is -p/q: positive in tension (1/3 in uniaxial tension)");
        }
        if let DamageEvolution::Displacement(displacement) = criterion.evolution
            && let Some(length) = smallest_size(model, index)
            && displacement > LARGEST_FAILURE_STRAIN * length
        {
            let message = format!(
                "the displacement at failure {displacement:e} of `{name}` is {:.0} times the size {length:.3e} of its smallest \
                 elements: they need this plastic strain after damage initiation",
                displacement / length
            );
            implausible(findings, message, "the plastic displacement at failure is in the unit of length of the deck");
        }
    }
}

/// Returns the length of the shortest side of the solid elements of a material.
fn smallest_size(model: &Model, material: usize) -> Option<f64> {
    let sections = model.sections.iter().filter(|section| section.material.index() == material);
    let elements = sections.flat_map(|section| &section.elements);
    elements.map(|element| model.mesh.side_lengths(*element)[0]).reduce(f64::min)
}

/// Returns whether a table at one rate and temperature only increases with the triaxiality.
fn increases_with_triaxiality(rows: &[[f64; 4]]) -> bool {
    let bits = |row: &[f64; 4]| [row[2].to_bits(), row[3].to_bits()];
    let is_one_curve = rows.iter().all(|row| bits(row) == bits(&rows[0]));
    rows.len() > 1 && is_one_curve && rows.windows(2).all(|pair| pair[1][1] > pair[0][1] && pair[1][0] > pair[0][0])
}

fn check_rubber(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let Some(law) = &material.hyperelastic else { return };
    let Some(d1) = law.compressibility.first().copied().filter(|d1| *d1 > 0.0) else { return };
    let ratio = 2.0 / d1 / law.shape.shear();
    if ratio > 0.0 && ratio < LEAST_BULK_PER_SHEAR {
        let message = format!(
            "the bulk modulus 2/D1 = {:e} of `{}` is {ratio:.1e} of its shear modulus: Poisson's ratio is {:.2}; rubber has more \
             than 0.45",
            2.0 / d1,
            material.name,
            (3.0 * ratio - 2.0) / (6.0 * ratio + 2.0)
        );
        implausible(findings, message, "D1 is 2 over the bulk modulus, in the inverse of the unit of C10");
    }
}

fn check_foam(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let (Some([modulus, _]), Some([first, _])) = (material.elastic, material.foam.hardening.first().copied()) else {
        return;
    };
    if material.foam.shape.is_some() && first > FOAM_YIELD * modulus {
        let message = format!(
            "the yield stress {first:e} of the foam `{}` is {:.1} times its Young's modulus; foams have 0.01 to 0.1",
            material.name,
            first / modulus
        );
        implausible(findings, message, "*CRUSHABLE FOAM HARDENING and *ELASTIC need the same unit");
    }
}

/// Checks soils and concrete.
fn check_geomaterials(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let (name, cards) = (&material.name, &material.strength);
    let friction = cards.drucker_prager.as_ref().filter(|(card, _)| card.form < 2).map(|(card, _)| card.row[0]);
    let dilation = cards.concrete.as_ref().map(|(card, _)| card.row[0]);
    let angles = [("friction angle", friction), ("dilation angle", dilation)];
    for (angle, value) in angles.into_iter().filter_map(|(name, value)| Some((name, value?))) {
        if value <= RIGHT_ANGLE {
            let message = format!("the {angle} {value} of `{name}` is probably in radians");
            implausible(findings, message, "give angles in degrees");
        }
    }
    let (Some((hardening, _)), Some((stiffening, _))) = (&cards.compression_hardening, &cards.tension_stiffening)
    else {
        return;
    };
    let peak = hardening.rows.iter().copied().reduce(|a, b| if b[0] > a[0] { b } else { a });
    let tension = stiffening.rows.iter().map(|row| row[0]).fold(0.0, f64::max);
    let Some([strength, strain, _]) = peak else { return };
    if tension > TENSION_PER_COMPRESSION * strength {
        let message = format!(
            "the tensile strength {tension:e} of `{name}` is {:.2} of its compressive strength; concrete has 0.05 to 0.15",
            tension / strength
        );
        implausible(findings, message, "check *CONCRETE TENSION STIFFENING and *CONCRETE COMPRESSION HARDENING");
    }
    if hardening.rows.len() > 1 && strain > CRUSHING_STRAIN {
        let message = format!(
            "`{name}` reaches its compressive strength at an inelastic strain of {strain}; concrete has 0.001 to 0.02"
        );
        implausible(findings, message, "inelastic strains are fractions, 0.002 for 0.2 %");
    }
}

/// Warns if one of initial and transition temperature is near 293 K and the other is near 20 deg C.
fn check_temperature_scales(model: &Model, material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let Some(PlasticityModel::JohnsonCook([.., melting, transition])) = material.plastic else { return };
    let differ = |a: f64, b: f64| {
        within(a, ROOM_IN_KELVIN) && within(b, ROOM_IN_CELSIUS)
            || within(b, ROOM_IN_KELVIN) && within(a, ROOM_IN_CELSIUS)
    };
    let mut initial = model.initial_conditions.iter().filter_map(|condition| condition.kind.temperature());
    let Some(initial) = initial.find(|initial| differ(*initial, transition)).filter(|_| melting > transition) else {
        return;
    };
    let message = format!(
        "the initial temperature {initial} and the transition temperature {transition} of `{}` are room temperature in kelvin and \
         in deg C",
        material.name
    );
    findings.push(Finding { code: "P141", message, help: "give both temperatures on one scale" });
}
