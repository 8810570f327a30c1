//! Warnings for implausible constants of materials, missing thermal data, implausible controls and elongated elements.
//! Each names the value and the usual range. Units and velocities are checked in `plausibility.rs`.

use std::collections::HashSet;

use crate::deck::Diagnostic;
use crate::model::{
    InitialKind, MaterialDefinition, Model, OutputInterval, PlasticityModel, RateDependence, StrainAtFailure,
    is_without_units,
};
use crate::plan::Report;
use crate::plan::checks::equations_of_state::check_equation_of_state;
use crate::plan::checks::finding::{Finding, used_materials, warn_about};
use crate::plan::checks::strengths::check_strength;

/// Largest usual hardening exponent of the Johnson-Cook law; published fits of metals are between 0.05 and 1.
const LARGEST_EXPONENT: f64 = 1.0;
/// Initial temperature from which temperatures are probably in kelvin, so that no body starts at 0.
const LEAST_KELVIN: f64 = 250.0;
/// Largest constant C of the Johnson-Cook law; published fits of metals have 0.001 to 0.1.
const LARGEST_RATE_CONSTANT: f64 = 0.2;
/// Usual range of specific heat times one kelvin over the squared wave speed: polymers 7e-4, steel 2e-5, tungsten 7e-6.
const HEAT_PER_STIFFNESS: [f64; 2] = [1e-6, 1e-2];
/// Range of the initial yield stress over Young's modulus: soft pure metals have 1e-5, polymers 0.05, and the theoretical
/// strength of a perfect crystal is about 0.1.
const YIELD_PER_STIFFNESS: [f64; 2] = [1e-6, 0.2];
/// Coefficients of bulk viscosity above which a mistake is assumed, linear and quadratic (defaults 0.06 and 1.2).
const LARGEST_VISCOSITY: [f64; 2] = [0.5, 10.0];
/// Mass factor above which a mistake is assumed: it multiplies all times of motion by 100.
const LARGEST_MASS_FACTOR: f64 = 1e4;
/// Ratio of the longest edge of an element to its shortest, or to the median of all elements, above which a wrong coordinate is assumed.
const LARGEST_ELONGATION: f64 = 300.0;

/// Warns of implausible materials, controls and elements of deformable bodies.
pub fn check_values(model: &Model, report: &mut Report) {
    for (index, material) in used_materials(model) {
        let mut findings = Vec::new();
        plasticity(material, &mut findings);
        failure(material, &mut findings);
        stiffness(material, &mut findings);
        check_temperatures(model, material, &mut findings);
        check_strength(model, (index, material), &mut findings);
        check_equation_of_state(model, material, &mut findings);
        for Finding { code, message, help } in findings {
            warn_about(code, message, (material.span, "this material"), help, report);
        }
    }
    check_controls(model, report);
    check_edges(model, report);
    check_fixed_velocities(model, report);
    check_missing_temperatures(model, report);
}

/// Warns of thermal elements without an initial temperature, while others have one that is probably in kelvin.
fn check_missing_temperatures(model: &Model, report: &mut Report) {
    let conditions = || model.initial_conditions.iter().filter(|c| c.kind.temperature().is_some());
    let Some(first) = conditions()
        .find(|c| c.kind.temperature().is_some_and(|value| value >= LEAST_KELVIN))
        .filter(|_| model.solves_for_temperatures())
    else {
        return;
    };
    let known: HashSet<usize> = conditions().flat_map(|condition| condition.members.iter().copied()).collect();
    let is_cold = |e: &&usize| {
        let element = &model.mesh.elements[**e];
        element.kind.is_thermal() && element.nodes.iter().all(|node| !known.contains(node))
    };
    for section in &model.sections {
        if let Some(&element) = section.elements.iter().find(is_cold) {
            let message = format!(
                "element {} conducts heat and has no initial temperature: it starts at 0, and other bodies at {}",
                model.mesh.elements[element].name,
                first.kind.temperature().unwrap_or_default()
            );
            let help = "give *INITIAL CONDITIONS, TYPE=TEMPERATURE for all bodies";
            return warn_about("P141", message, (section.span, "this section"), help, report);
        }
    }
}

/// Warns of an initial velocity all of whose nodes are fixed.
fn check_fixed_velocities(model: &Model, report: &mut Report) {
    let Some(step) = model.steps.first() else { return };
    for condition in &model.initial_conditions {
        let InitialKind::Velocity(dof, velocity) = condition.kind else { continue };
        let fixed = step.boundaries.iter().filter(|b| b.dof == dof && b.value == 0.0 && !b.user);
        let mut holding = fixed.filter(|b| condition.members.iter().all(|n| b.nodes.contains(n)));
        let Some(boundary) = holding.next().filter(|_| velocity != 0.0 && condition.members.len() > 1) else {
            continue;
        };
        let message = format!(
            "all {} nodes with the initial velocity {velocity} along {dof} are fixed in this direction: they do not move",
            condition.members.len()
        );
        let help = match model.element_sets.contains_key(&boundary.set.to_ascii_uppercase()) {
            true => {
                "*BOUNDARY applies to the node set, and there is an element set of the same name: give the set of the nodes to be fixed"
            }
            false => "give *BOUNDARY the set of the nodes to be fixed",
        };
        let finding = Diagnostic::warning("P145", message).at(boundary.span, "fixes all these nodes");
        report.push(finding.at(condition.span, "their initial velocity").help(help));
    }
}

/// Checks initial temperatures against the temperature dependence, and heating by plastic work.
fn check_temperatures(model: &Model, material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let name = &material.name;
    let initial = || model.initial_conditions.iter().filter_map(|condition| condition.kind.temperature());
    let heated = model.is_adiabatic() || model.solves_for_temperatures();
    if let Some(PlasticityModel::JohnsonCook([.., melting, transition])) = material.plastic
        && melting > transition
    {
        let hottest = initial().fold(f64::NEG_INFINITY, f64::max);
        if hottest >= melting {
            let message = format!(
                "the initial temperature {hottest} is not below the melting temperature {melting} of `{name}`, which \
                 has no strength there"
            );
            findings.push(Finding {
                code: "P141",
                message,
                help: "check the unit of temperatures (K or deg C) in the deck",
            });
        } else if heated && transition > 0.0 && initial().next().is_none() {
            let message = format!(
                "there is no initial temperature: `{name}` starts at 0, below its transition temperature {transition}, and \
                 does not soften until it has reached it"
            );
            findings.push(Finding { code: "P141", message, help: "add *INITIAL CONDITIONS, TYPE=TEMPERATURE" });
        }
    }
    if model.is_adiabatic() && material.plastic.is_some() && material.user.material.is_none() {
        let thermal = &material.thermal;
        let missing = [
            ("*SPECIFIC HEAT", thermal.specific_heat.is_none()),
            ("*INELASTIC HEAT FRACTION", thermal.inelastic_heat_fraction.is_none()),
        ];
        let missing: Vec<&str> = missing.iter().filter(|m| m.1).map(|m| m.0).collect();
        if !missing.is_empty() {
            let message =
                format!("the step is ADIABATIC, but `{name}` has no {}: it is not heated", missing.join(", no "));
            findings.push(Finding { code: "P142", message, help: "add the cards, or remove ADIABATIC from *DYNAMIC" });
        }
    }
}

fn check_controls(model: &Model, report: &mut Report) {
    let mut warn = |message, place, help| warn_about("P143", message, place, help, report);
    for step in &model.steps {
        let viscosity = step.bulk_viscosity;
        let values = [viscosity.linear, viscosity.quadratic];
        for (i, term) in ["linear", "quadratic"].into_iter().enumerate() {
            if values[i] > LARGEST_VISCOSITY[i] {
                let message = format!(
                    "the {term} bulk viscosity {} of step `{}` is implausibly large (default {})",
                    values[i],
                    step.name,
                    [0.06, 1.2][i]
                );
                let help = "the coefficients of *BULK VISCOSITY are dimensionless: 0.06, 1.2";
                warn(message, (step.span, "this step"), help);
            }
        }
        for scaling in step.mass_scalings.iter().filter(|s| s.factor > LARGEST_MASS_FACTOR) {
            let message = format!(
                "masses are multiplied by {:e}: inertia governs the motion unless it takes {:.0} times as long as in reality",
                scaling.factor,
                scaling.factor.sqrt()
            );
            let help = "give a smaller FACTOR, or DT with TYPE=BELOW MIN, and compare ALLKE with ALLIE";
            warn(message, (scaling.span, "this mass scaling"), help);
        }
        for output in &step.outputs {
            if let OutputInterval::Time(interval) = output.interval
                && interval > step.duration
            {
                let message = format!(
                    "the output interval {interval:e} is longer than step `{}` of duration {:e}: only the start and the end \
                     are written",
                    step.name, step.duration
                );
                warn(message, (output.span, "this output request"), "give a shorter TIME INTERVAL");
            }
        }
    }
}

/// Warns of elements that are much longer than wide, or than most elements, as if a coordinate of a node had a wrong
/// power of ten.
fn check_edges(model: &Model, report: &mut Report) {
    let mesh = &model.mesh;
    let elements = model.sections.iter().flat_map(|s| s.elements.iter().copied());
    let sides = elements.map(|e| (&mesh.elements[e], mesh.side_lengths(e)));
    let extremes = sides.clone().fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], (_, [shortest, longest])| {
        [least.min(shortest), most.max(longest)]
    });
    // Large meshes of similar elements need no lists.
    if extremes[1] <= LARGEST_ELONGATION * extremes[0] {
        return;
    }
    let sides: Vec<_> = sides.collect();
    let mut longest: Vec<f64> = sides.iter().map(|(_, [_, most])| *most).collect();
    let middle = longest.len() / 2;
    let median = *longest.select_nth_unstable_by(middle, f64::total_cmp).1;
    let elongated = sides.iter().filter_map(|&(element, [least, most])| {
        let elongation = most / least.min(median);
        (elongation > LARGEST_ELONGATION).then_some((element, most, elongation))
    });
    let far: Vec<_> = elongated.collect();
    let Some(&(element, length, elongation)) = far.first() else { return };
    let message = format!(
        "element {}{} has an edge of length {length:e}, {elongation:.0} times as long as its shortest edge or as most \
         edges",
        element.name,
        if far.len() > 1 { format!(" (and {} more)", far.len() - 1) } else { String::new() },
    );
    let help = "check the coordinates of its nodes: one may have a wrong power of ten";
    warn_about("P144", message, (element.span, "this element"), help, report);
}

/// Checks the constants of the yield stress and of its rate dependence.
fn plasticity(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let name = &material.name;
    let mut implausible = |message: String, help| findings.push(Finding { code: "P140", message, help });
    match &material.plastic {
        Some(PlasticityModel::JohnsonCook([a, b, n, m, melting, transition])) => {
            let order = "the order of the constants is A, B, n, m, melting temperature, transition temperature";
            if *a <= 0.0 {
                let message = format!("the yield stress A = {a} of `{name}` is not positive: it flows under any load");
                implausible(message, order);
            }
            if *b < 0.0 {
                implausible(format!("B = {b} of `{name}` is negative: it softens from the start"), order);
            }
            if *n > LARGEST_EXPONENT {
                let message = format!("the hardening exponent n = {n} of `{name}` is above 1; metals have 0.05 to 1");
                implausible(message, order);
            }
            if *melting != 0.0 && melting <= transition {
                let message = format!(
                    "the melting temperature {melting} of `{name}` is not above its transition temperature {transition}"
                );
                implausible(message, order);
            } else if *melting != 0.0 && *m <= 0.0 {
                implausible(format!("the exponent m = {m} of `{name}` is not positive"), order);
            }
        }
        Some(PlasticityModel::Tabular(rows)) => {
            let help = "the rows of *PLASTIC are yield stress, plastic strain, temperature";
            if rows.first().is_some_and(|row| row[0] <= 0.0) {
                implausible(format!("the initial yield stress of `{name}` is 0: it flows under any load"), help);
            }
            if let [first, second, ..] = rows[..]
                && second[1] > first[1]
                && second[0] < first[0]
            {
                implausible(format!("`{name}` softens from the start: {} after {}", second[0], first[0]), help);
            }
        }
        _ => {}
    }
    let first = material.plastic.as_ref().and_then(PlasticityModel::initial_yield_stress);
    // Poisson's ratio 0.3 gives the modulus of a material with *EOS.
    let modulus = material.elastic.map(|[modulus, _]| modulus).or(material.shear_modulus.map(|shear| 2.6 * shear));
    let ratio = first.zip(modulus).map(|(stress, modulus)| stress / modulus).filter(|ratio| *ratio > 0.0);
    if let Some(ratio) = ratio.filter(|ratio| !(YIELD_PER_STIFFNESS[0]..=YIELD_PER_STIFFNESS[1]).contains(ratio)) {
        let message =
            format!("the yield stress of `{name}` is {ratio:.1e} of its Young's modulus; metals have 1e-5 to 0.02");
        implausible(message, "yield stress and modulus need the same unit: MPa in mm, t, s and Pa in m, kg, s");
    }
    if let Some(RateDependence::JohnsonCook([c, _])) = material.rate
        && !(0.0..=LARGEST_RATE_CONSTANT).contains(&c)
    {
        let message = format!(
            "the rate constant C = {c} of `{name}` is outside 0 to {LARGEST_RATE_CONSTANT}; metals have 0.001 to 0.1"
        );
        implausible(message, "the order of the constants is C, reference strain rate");
    }
}

/// Checks the constants of Johnson-Cook failure, `d1 + d2 exp(-d3 η)` with the stress triaxiality η (ABAQUS Analysis
/// User's Guide 23.2.2). Johnson and Cook (1985, Eng. Fract. Mech. 21, 31) write `exp(D3 σ*)`.
fn failure(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let name = &material.name;
    for criterion in &material.failures {
        let StrainAtFailure::JohnsonCook([d1, d2, d3, ..], _) = criterion.strain else { continue };
        let mut implausible = |message: String, help| findings.push(Finding { code: "P140", message, help });
        if d2 > 0.0 && d3 == 0.0 {
            let message = format!("d3 of the failure of `{name}` is 0: the stress triaxiality has no effect");
            implausible(
                message,
                "the order of the constants is d1, d2, d3, d4, d5, melting temperature, transition temperature, reference strain rate",
            );
        }
        if d2 > 0.0 && d3 < 0.0 {
            let message =
                format!("d3 = {d3} of the failure of `{name}` is negative: tension raises the strain at failure");
            implausible(
                message,
                "the exponent is -d3 times the triaxiality: give the published D3 with the opposite sign",
            );
        }
        if d1 + d2 <= 0.0 {
            let message = format!("the strain at failure of `{name}` in shear, d1 + d2 = {}, is not positive", d1 + d2);
            implausible(message, "elements fail at the first plastic strain");
        }
    }
}

/// Checks the equation of state against the shear modulus, and the specific heat against the stiffness.
fn stiffness(material: &MaterialDefinition, findings: &mut Vec<Finding>) {
    let (name, Some(density)) = (&material.name, material.density) else { return };
    if let (Some(bulk), Some(shear)) = (material.bulk_modulus(None), material.shear_modulus)
        && shear > 1.5 * bulk
    {
        let message = format!(
            "the shear modulus {shear:e} of `{name}` is above 1.5 times the bulk modulus of *EOS, {bulk:e}: Poisson's ratio \
             is negative"
        );
        findings.push(Finding { code: "P140", message, help: "check the units of the shear modulus and of *EOS" });
    }
    if let (Some([modulus, _]), Some(heat), true) =
        (material.elastic, &material.thermal.specific_heat, material.plastic.is_some())
        && !is_without_units(density)
    {
        let heat = heat.first().map_or(0.0, |row| row[0]);
        let [least, most] = HEAT_PER_STIFFNESS;
        let ratio = heat * density / modulus;
        if !(least..=most).contains(&ratio) {
            let message = format!(
                "the specific heat {heat:e} of `{name}` is implausible for its modulus and density: plastic work of 1 % strain at \
                 a stress of E/1000 heats it by {:.1e}",
                1e-5 / ratio
            );
            let help = "specific heat is energy per mass and kelvin in the units of the deck: steel has 460 in m, kg, s and 4.6e8 in mm, t, s";
            findings.push(Finding { code: "P140", message, help });
        }
    }
}
