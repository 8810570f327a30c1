//! Temperature-dependent material tables, and section controls.
//!
//! Goal: density, specific heat, rate factors and yield stresses are taken at the temperature; no input is silently
//! ignored.
//! Source: closed forms for one element in uniaxial compression (stress = -yield stress, plastic strain = PEEQ); rules
//! of the ABAQUS Analysis User's Guide 21.2.1 "Density", 26.2.3 "Specific heat", 23.2.1 "Classical metal plasticity",
//! 23.2.3 "Rate-dependent yield", 27.1.4 "Section controls", and the Keywords Reference Guide.
//! Tolerance: 1e-3 of the value (inertia: rho v^2 is 1e-5 of the yield stress), 1e-2 with rate dependence.

use std::f64::consts::PI;

use crate::common;
use crate::common::solid;
use revolve::job;
use revolve::user::Routines;

/// Returns an element of 1 mm compressed uniaxially at 1 m/s for 0.3 ms.
fn compressed_element(material: &str, temperature: f64) -> String {
    solid::grid(1, 1, false, |i, j| [i as f64 * 1e-3, j as f64 * 1e-3])
        + &format!(
            "*Elset, elset=ONE\n 1\n*Solid section, elset=SOLID, material=M\n*Material, name=M\n{material}\
             *Initial conditions, type=TEMPERATURE\n ALL, {temperature}\n*Step\n*Dynamic, explicit, adiabatic\n , 3.e-4\n\
             *Boundary\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, -1.\n*Output, history, number interval=20\n\
             *Element output, elset=ONE\n TEMP, PEEQ, S22\n*Energy output\n ALLKE\n*End step\n"
        )
}

const STEEL: &str = "*Density\n 7800.,\n*Elastic\n 200.e9, 0.3\n";

/// Returns the final plastic strain and axial stress.
fn final_values(text: &str) -> [f64; 2] {
    let (_, memory) = solid::run(text);
    ["PEEQ@ONE", "S22@ONE"].map(|name| solid::last(text, &memory, name))
}

/// Returns the codes of all diagnostics, except that materials without specific heat are not heated (P142).
fn error_codes(text: &str) -> Vec<&'static str> {
    let prepared = job::prepare_text("case.inp", text, &[], &Routines::none());
    prepared.diagnostics.iter().map(|d| d.code).filter(|code| *code != "P142").collect()
}

#[track_caller]
fn assert_close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, expected {expected}");
}

/// rho c(T) dT = 0.9 dW with c = 500 J/kgK at 300 K and 1000 J/kgK from 301 K on: the first kelvin takes 750 J/kg.
#[test]
fn temperature_dependent_specific_heat_matches_closed_form() {
    let text = compressed_element(
        &format!(
            "{STEEL}*Plastic\n 500.e6, 0.\n*Specific heat\n 500., 300.\n 1000., 301.\n*Inelastic heat fraction\n 0.9\n"
        ),
        300.0,
    );
    let (_, memory) = solid::run(&text);
    let [temperature, strain] = ["TEMP@ONE", "PEEQ@ONE"].map(|name| solid::last(&text, &memory, name));
    let heat = 0.9 * 500e6 * strain / 7800.0;
    assert_close("rise", temperature - 300.0, 1.0 + (heat - 750.0) / 1000.0, 1e-3);
}

/// The density is that of the initial temperature: the kinetic energy of a cylinder at 1 m/s has the corresponding
/// mass.
#[test]
fn density_is_taken_at_the_initial_temperature() {
    let of = |temperatures: &str| {
        solid::grid(1, 1, false, |i, j| [i as f64, j as f64])
            + "*Solid section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1., 0.\n 3., 100.\n*Elastic\n 1.e3, 0.\n"
            + "*Initial conditions, type=VELOCITY\n ALL, 2, 1.\n"
            + temperatures
            + "*Step\n*Dynamic, explicit\n , 1.e-3\n*Output, history\n*Energy output\n ALLKE\n*End step\n"
    };
    for (temperatures, density) in [
        ("*Initial conditions, type=TEMPERATURE\n ALL, 50.\n", 2.0),
        ("*Initial conditions, type=TEMPERATURE\n ALL, 900.\n", 3.0),
        ("", 1.0),
    ] {
        let text = of(temperatures);
        let (_, memory) = solid::run(&text);
        assert_close(temperatures, solid::last(&text, &memory, "ALLKE"), 0.5 * density * PI, 1e-12);
    }
    assert_eq!(error_codes(&of("*Initial conditions, type=TEMPERATURE\n J0, 50.\n J1, 60.\n")), ["M104"]);
}

/// Yield stress ratios and the power law at a temperature between those of the table.
#[test]
fn rate_factors_depend_on_temperature() {
    let ratios = "*Plastic\n 500.e6, 0.\n*Rate dependent, type=YIELD RATIO\n 1., 0., 0.\n 1., 1.e9, 0.\n 0.5, 0., 100.\n 0.5, 1.e9, 100.\n";
    let [_, stress] = final_values(&compressed_element(&format!("{STEEL}{ratios}"), 50.0));
    assert_close("ratio of 0.75", stress, -0.75 * 500e6, 1e-3);
    let power = "*Plastic\n 500.e6, 0.\n*Rate dependent\n 1000., 1., 0.\n 3000., 1., 100.\n";
    let [_, stress] = final_values(&compressed_element(&format!("{STEEL}{power}"), 50.0));
    // The final height is 0.7 mm, the rate 1/0.7e-3 per second, D = 2000.
    assert_close("1 + rate/D", stress, -500e6 * (1.0 + 1.0 / 0.7e-3 / 2000.0), 1e-2);
}

/// EXTRAPOLATION=LINEAR applies to the plastic strain; the temperature is extrapolated as constant. CONSTANT is the
/// default.
#[test]
fn yield_stress_extrapolates_as_specified() {
    let table = " 500.e6, 0.\n 510.e6, 0.01\n";
    for (name, parameter) in [("default", ""), ("constant", ", extrapolation=CONSTANT")] {
        let [_, stress] = final_values(&compressed_element(&format!("{STEEL}*Plastic{parameter}\n{table}"), 300.0));
        assert_close(name, stress, -510e6, 1e-3);
    }
    // A rate table with factor 1 selects the general hardening law.
    for rate in ["", "*Rate dependent, type=YIELD RATIO\n 1., 0.\n 1., 1.e9\n"] {
        let [strain, stress] =
            final_values(&compressed_element(&format!("{STEEL}*Plastic, extrapolation=LINEAR\n{table}{rate}"), 300.0));
        assert_close("linear", stress, -(500e6 + 1e9 * strain), 1e-3);
    }
    let hot =
        "*Plastic, extrapolation=LINEAR\n 500.e6, 0., 0.\n 510.e6, 0.01, 0.\n 250.e6, 0., 100.\n 255.e6, 0.01, 100.\n";
    let [strain, stress] = final_values(&compressed_element(&format!("{STEEL}{hot}"), 900.0));
    assert_close("beyond the last temperature", stress, -(250e6 + 0.5e9 * strain), 1e-3);
    let soft = "*Plastic, extrapolation=LINEAR\n 500.e6, 0.\n 400.e6, 0.1\n";
    let [strain, stress] = final_values(&compressed_element(&format!("{STEEL}{soft}"), 300.0));
    assert_close("negative slope", stress, -(500e6 - 1e9 * strain), 2e-3);
}

/// Unsupported input is an error, input without effect is reported.
#[test]
fn no_material_input_is_silently_ignored() {
    let jc = "*Plastic, hardening=JOHNSON COOK\n 5.e8, 1.e8, 0.2, 1., 1500., 300.\n";
    for (cards, code) in [
        (format!("{STEEL}{jc} 5.e8, 1.e8, 0.2, 1., 1500., 300.\n"), "M162"),
        (format!("{STEEL}{jc}*Rate dependent, type=JOHNSON COOK\n 0.01, 1.\n 0.02, 1.\n"), "M162"),
        (format!("{STEEL}*Plastic, hardening=KINEMATIC, extrapolation=LINEAR\n 5.e8, 0.\n 6.e8, 0.1\n"), "M104"),
        (format!("{STEEL}*Plastic, extrapolation=CUBIC\n 5.e8, 0.\n"), "M103"),
        (format!("{STEEL}*Plastic\n 5.e8, 0.\n*Rate dependent\n 40., 5., 100.\n 40., 5., 0.\n"), "M103"),
        (format!("{STEEL}*Plastic\n 5.e8, 0.\n*Specific heat\n 500., 300.\n 600.\n"), "M103"),
        ("*Density\n 7800., 20.\n 7700., 10.\n*Elastic\n 200.e9, 0.3\n".into(), "M103"),
    ] {
        assert!(
            error_codes(&compressed_element(&cards, 300.0)).contains(&code),
            "{cards}: {:?}",
            error_codes(&compressed_element(&cards, 300.0))
        );
    }
    let controlled = |parameter: &str, more: &str| {
        let text = compressed_element(&format!("{STEEL}*Plastic\n 5.e8, 0.\n{more}"), 300.0);
        text.replace("material=M\n", &format!("material=M, controls=C\n*Section controls, name=C{parameter}\n"))
    };
    let fails = "*Shear failure, element deletion=YES\n 0.3,\n";
    assert!(error_codes(&controlled(", element deletion=NO", fails)).contains(&"M104"));
    assert!(error_codes(&controlled(", element deletion=NO", "")).is_empty(), "no failure criterion");
    assert!(error_codes(&controlled(", element deletion=YES", fails)).is_empty());
    let prepared = common::prepared(&controlled(", second order accuracy=YES", ""), &[], &Routines::none());
    assert!(prepared.plan.ledger.unused.iter().any(|u| u.what.contains("SECOND ORDER ACCURACY")));
    let prepared = common::prepared(&controlled(", ramp initial stress=NO", ""), &[], &Routines::none());
    assert!(prepared.plan.ledger.unused.iter().any(|u| u.why.contains("membranes")));
}

/// `*BULK VISCOSITY` (Analysis User's Guide 6.3.3) is valid before and after `*DYNAMIC`, and in later steps until it is
/// redefined.
#[test]
fn bulk_viscosity_persists_over_steps() {
    let of = |first: &str, second: &str| {
        solid::grid(1, 4, false, |i, j| [i as f64, j as f64])
            + &solid::material(1e6, 0.3, 1.0, "")
            + &format!(
                "*Step\n{first}*Dsload\n J0, P, 1000.\n*Output, history\n*Energy output\n ALLVD\n*End step\n\
                 *Step\n{second}*End step\n"
            )
    };
    let (viscosity, dynamic) = ("*Bulk viscosity\n 0., 0.\n", "*Dynamic, explicit\n , 0.01\n");
    let lost = |text: &str| solid::last(text, &solid::run(text).1, "ALLVD");
    let before = of(&format!("{viscosity}{dynamic}"), dynamic);
    assert_eq!(lost(&before), 0.0, "before *DYNAMIC, also in the next step");
    assert_eq!(lost(&of(&format!("{dynamic}{viscosity}"), dynamic)), 0.0);
    assert!(lost(&of(dynamic, dynamic)) > 0.0);
}
