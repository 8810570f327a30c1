//! Checks of the constants of equations of state: Hugoniots against measured ones, gases against kinetic theory, explosives
//! against the condition of Chapman and Jouguet.

use super::finding::{Finding, warn_about};
use crate::model::{EosKind, MaterialDefinition, Model};
use crate::plan::Report;

/// Range of the slope s of measured Hugoniots `Us = c0 + s Up` of solids and liquids (Marsh, LASL Shock Hugoniot Data,
/// 1980): most are between 0.7 and 2.2. 0 means a linear pressure and is allowed.
const SLOPES: [f64; 2] = [0.3, 3.0];
/// Range of the ratio of the specific heats of a gas: 1.04 of heavy molecules to 5/3 of atoms, with a margin.
const HEAT_RATIOS: [f64; 2] = [1.02, 1.7];
/// Absolute temperature below which only hydrogen and helium are gases at the pressure of the atmosphere, K.
const COLDEST_GAS: f64 = 25.0;
/// Accepted difference between the detonation wave speed and that of the Chapman-Jouguet condition, relative to the first.
/// Published sets differ by up to 2 %.
const SPEED_TOLERANCE: f64 = 0.05;
/// Relative volumes of detonation products between which the Chapman-Jouguet point is sought; it is near 0.75.
const VOLUMES: [f64; 2] = [0.3, 0.95];
const VOLUME_COUNT: u32 = 400;

/// Adds the findings on the equation of state of a material.
pub fn check_equation_of_state(model: &Model, material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    match material.eos.as_ref().map(|eos| &eos.kind) {
        Some(EosKind::UsUp([_, slope, _])) => check_slope(material, *slope, findings),
        Some(EosKind::IdealGas([gas_constant, _])) => check_gas(model, material, *gas_constant, findings),
        Some(EosKind::Jwl(constants)) => check_detonation_speed(material, constants, findings),
        _ => {}
    }
}

fn check_slope(material: &MaterialDefinition, slope: f64, findings: &mut Vec<Finding>) {
    let [least, most] = SLOPES;
    if slope != 0.0 && !(least..=most).contains(&slope) {
        let name = &material.name;
        let message = format!(
            "the slope s = {slope} of the Hugoniot of `{name}` is outside {least} to {most}; solids and liquids have 0.7 to 2.2"
        );
        let help = "the order of the constants of *EOS, TYPE=USUP is c0, s, Gamma0; s is dimensionless";
        findings.push(Finding { code: "P140", message, help });
    }
}

fn check_gas(model: &Model, material: &MaterialDefinition, gas_constant: f64, findings: &mut Vec<Finding>) {
    let name = &material.name;
    let heat = material.thermal.specific_heat.as_ref().and_then(|rows| rows.first()).map(|row| row[0]);
    let ratio = heat.map(|heat| 1.0 + gas_constant / heat);
    let [least, most] = HEAT_RATIOS;
    if let Some(ratio) = ratio.filter(|ratio| !(least..=most).contains(ratio)) {
        let message = format!(
            "the gas constant {gas_constant:e} and the specific heat of `{name}` give a ratio of specific heats of {ratio:.4}; \
             gases have 1.04 to 1.67"
        );
        let help = "*EOS, TYPE=IDEAL GAS needs the universal gas constant over the molar mass, *SPECIFIC HEAT the value at constant volume: air has 287 and 718 J/(kg K)";
        findings.push(Finding { code: "P140", message, help });
    }
    let zero = model.settings.absolute_zero;
    let initial = model.initial_conditions.iter().filter_map(|condition| condition.kind.temperature());
    let coldest = initial.map(|temperature| temperature - zero).fold(f64::INFINITY, f64::min);
    if (0.0..COLDEST_GAS).contains(&coldest) && coldest > 0.0 && temperatures_are_absolute(model) {
        let message =
            format!("the absolute initial temperature {coldest} of the gas `{name}` is below its boiling point");
        let help = "with temperatures in deg C give *PHYSICAL CONSTANTS, ABSOLUTE ZERO=-273.15";
        findings.push(Finding { code: "P141", message, help });
    }
}

/// Returns whether temperatures have the scale of kelvin or deg C.
fn temperatures_are_absolute(model: &Model) -> bool {
    model.settings.units.as_ref().is_none_or(|units| matches!(units.temperature.as_str(), "K" | "C"))
}

/// Compares the detonation wave speed of the card with that of the constants.
fn check_detonation_speed(material: &MaterialDefinition, constants: &[f64; 8], findings: &mut Vec<Finding>) {
    let (Some(density), [speed, ..]) = (material.density, *constants) else { return };
    let name = &material.name;
    let computed = chapman_jouguet_speed(density, constants);
    if computed.is_some_and(|computed| (computed / speed - 1.0).abs() <= SPEED_TOLERANCE) || constants[6] == 0.0 {
        return;
    }
    let message = match computed {
        Some(computed) => format!(
            "density, A, B, R1, R2, omega and detonation energy of `{name}` give a detonation wave speed of {computed:.4e} \
             (Chapman-Jouguet), the card has {speed:.4e}"
        ),
        None => format!(
            "the constants of *EOS, TYPE=JWL of `{name}` have no Chapman-Jouguet point: they allow no detonation"
        ),
    };
    let help = "the order of the constants is D, A, B, omega, R1, R2, detonation energy per mass; published sets agree within 2 %";
    findings.push(Finding { code: "P140", message, help });
}

/// Returns the smallest speed of a steady detonation, at which the line of Rayleigh touches the Hugoniot of the products
/// (Chapman and Jouguet; Lee, Hornig and Kury, UCRL-50422, 1968), length per time. `None` if there is none.
fn chapman_jouguet_speed(density: f64, &[_, a, b, omega, r1, r2, energy, _]: &[f64; 8]) -> Option<f64> {
    let squared_speed = |index: u32| {
        let [low, high] = VOLUMES;
        let volume = low + (high - low) * f64::from(index) / f64::from(VOLUME_COUNT);
        let term = |factor: f64, rate: f64| factor * (1.0 - omega / (rate * volume)) * libm::exp(-rate * volume);
        let thermal = omega * density * energy / volume;
        let own_share = 1.0 - 0.5 * omega * (1.0 - volume) / volume;
        let pressure = (term(a, r1) + term(b, r2) + thermal) / own_share;
        (own_share > 0.0).then_some(pressure / (density * (1.0 - volume)))
    };
    let least = (0..=VOLUME_COUNT).filter_map(squared_speed).fold(f64::INFINITY, f64::min);
    (least > 0.0 && least.is_finite()).then(|| least.sqrt())
}

/// Warns of explosives whose detonation begins after the end of the analysis.
pub fn check_detonation_times(model: &Model, report: &mut Report) {
    let end: f64 = model.steps.iter().map(|step| step.duration).sum();
    for section in &model.sections {
        let Some(material) = model.materials.get(section.material.index()) else { continue };
        let Some(EosKind::Jwl([speed, ..])) = material.eos.as_ref().map(|eos| &eos.kind) else { continue };
        let nodes = section.elements.iter().flat_map(|&e| &model.mesh.elements[e].nodes);
        let arrival = |point: [f64; 2]| {
            let times =
                material.detonation.iter().map(|[r, z, delay]| delay + libm::hypot(point[0] - r, point[1] - z) / speed);
            times.fold(f64::INFINITY, f64::min)
        };
        let first = nodes.map(|&n| arrival(model.mesh.points[n])).fold(f64::INFINITY, f64::min);
        if first.is_finite() && first >= end && end > 0.0 {
            let message = format!(
                "`{}` does not detonate: the wave reaches it at time {first:.4e}, and the analysis ends at {end:.4e}",
                material.name
            );
            let help = "check coordinates and delay of *DETONATION POINT, the detonation wave speed and the length of the step";
            warn_about("P153", message, (material.span, "this material"), help, report);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::chapman_jouguet_speed;

    /// Goal: the speed of published sets follows from their other constants. Source: Dobratz and Crawford, LLNL Explosives
    /// Handbook, UCRL-52997, 1985 (density, D, A, B, omega, R1, R2, energy per volume).
    #[test]
    fn detonation_speed_of_published_sets_matches_chapman_jouguet() {
        let sets = [
            [1630.0, 6930.0, 371.2e9, 3.231e9, 0.30, 4.15, 0.95, 7.0e9],
            [1601.0, 8193.0, 609.77e9, 12.95e9, 0.25, 4.5, 1.4, 9.0e9],
            [1840.0, 8800.0, 852.4e9, 18.02e9, 0.38, 4.6, 1.3, 10.2e9],
            [1717.0, 7980.0, 524.2e9, 7.678e9, 0.34, 4.2, 1.1, 8.5e9],
        ];
        for [density, speed, a, b, omega, r1, r2, energy] in sets {
            let computed = chapman_jouguet_speed(density, &[speed, a, b, omega, r1, r2, energy / density, 0.0]);
            let computed = computed.unwrap_or_default();
            assert!((computed / speed - 1.0).abs() < 0.002, "{computed} {speed}");
        }
        let swapped = [6930.0, 371.2e9, 3.231e9, 0.30, 0.95, 4.15, 4.29e6, 0.0];
        assert!(chapman_jouguet_speed(1630.0, &swapped).is_none_or(|speed| (speed / 6930.0 - 1.0).abs() > 0.05));
    }
}
