//! Refinement studies of models with known results.
//!
//! Goal: the observed orders are those of the methods; the true error is within the reported uncertainty; a target is
//! met by a setting that is not much more expensive than necessary. Source: the closed forms in `study_cases.rs`.

use std::time::Duration;

use revolve::job::ParameterOverrides;
use revolve::study::causes;
use revolve::study::chosen::{self, TargetRequest};
use revolve::study::convergence::{self, RefinementRequest};
use revolve::study::inputs::RandomInputs;
use revolve::study::jitter::NoiseRequest;
use revolve::study::noise::Divergence;
use revolve::study::quantity::Quantity;
use revolve::study::refinement::{self, RefinementStudy};
use revolve::study::richardson::ConvergenceBehaviour;
use revolve::study::runner::{RunSource, StudyRunner};
use revolve::study::settings;
use revolve::study::target::{self, ErrorTarget};
use revolve::study::uncertainty::{self, ModelTraits, RunCertificate, UncertaintyRequest};

use crate::common::solid::{grid, material};
use crate::common::spheres::SKEWED;
use crate::study_cases::{self as cases, StudyCase};

/// Runs the refinement study of a case, with or without its exact value.
fn study(case: &StudyCase, with_exact: bool) -> RefinementStudy {
    let measure = Quantity::parse(&case.quantity).expect("a quantity");
    let axes = settings::axes(&[case.refine.to_owned()], &["n".to_owned()]).expect("levels");
    let mut bench = StudyRunner::new(&*case.deck, &[], None, &measure, 1, &|| {});
    let study = refinement::grid(&mut bench, &axes, with_exact.then_some(case.exact)).expect("a study");
    for row in &study.rows {
        assert!(row.run.is_ok(), "{}: {:?}", case.name, row.run);
    }
    study
}

/// Bar: the order from the last two errors of each case is that of the method, within 0.1.
#[test]
fn observed_orders_match_the_methods() {
    let lagged = cases::increments("LAGGED");
    let facets = cases::facets();
    let expected: Vec<(StudyCase, f64)> = facets
        .into_iter()
        .take(4)
        .chain(cases::increments("PREDICTED"))
        .chain([cases::wave_in_space(), cases::wave_top(), cases::wave_in_time()])
        .map(|case| (case, 2.0))
        .chain(lagged.into_iter().map(|case| (case, 1.0)))
        .collect();
    for (case, order) in expected {
        let study = study(&case, true);
        let found = study.rows.last().and_then(|r| r.exact_orders.last()).copied().flatten().expect("an order");
        println!("{}: order {found:.3}", case.name);
        assert!((found - order).abs() < 0.1, "{}: {found}", case.name);
    }
}

/// A Taylor bar with new meshes on three meshes; SIZE follows the mesh. The lengths differ by less than 1 % from coarse to
/// fine and converge: the estimated limit is that without new meshes within 0.1 %, and the noise is measured by default.
#[test]
fn new_meshes_converge() {
    let bar = std::fs::read_to_string(crate::common::project("input/taylor_copper.inp")).expect("the deck");
    let limits = ["", "*Remesh, elset=BAR, angle=40., frequency=5\n", "*Remesh, elset=BAR, angle=40., size=0.4e-3\n"]
        .map(|card| {
            let text = bar.replacen("*Material, name=COPPER", &format!("{card}*Material, name=COPPER"), 1);
            let source = |overrides: &ParameterOverrides| revolve::deck::read_text("case.inp", &text, overrides);
            let measure = Quantity::parse("final(COOR2@TIP)").expect("a quantity");
            let axes = settings::axes(&["mesh=0.5,1,2".to_owned()], &[]).expect("levels");
            let mut bench = StudyRunner::new(&source, &[], None, &measure, 1, &|| {});
            let study = refinement::grid(&mut bench, &axes, None).expect("a study");
            let values: Vec<f64> = study.rows.iter().map(|row| row.value.expect("a value")).collect();
            let estimate =
                study.rows.last().and_then(|row| row.estimates.last()).copied().flatten().expect("an estimate");
            println!("{card}: {values:?}, limit {:e}, order {:?}", estimate.limit, estimate.order);
            assert!((values[0] / values[2] - 1.0).abs() < 0.01 && (values[1] / values[2] - 1.0).abs() < 0.003);
            let is_sensitive = causes::is_sensitive(&revolve::model::build(&source(&[]).0).0);
            assert_eq!(is_sensitive, !card.is_empty());
            estimate.limit
        });
    assert!(limits.iter().all(|limit| (limit / limits[0] - 1.0).abs() < 1e-3), "{limits:?}");
}

/// Returns the deck of Lamé's cylinder of radii 10 and 20 mm under 1 MPa with `n` by `m` listed skewed elements.
fn lame_cylinder(n: usize, m: usize) -> String {
    let place = |i: usize, j: usize| {
        let [x, y] = SKEWED([i as f64 / n as f64, j as f64 / m as f64]);
        [10.0 + 10.0 * x, 5.0 * y]
    };
    grid(n, m, false, place)
        + &material(200e3, 0.3, 7.85e-9, "")
        + "*Nset, nset=INNER\n 1,\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Step\n*Dynamic, Explicit\n , 4.e-4\n\
           *Boundary\n ALL, 2, 2\n*Dsload, amplitude=RAMP\n I0, P, 1.\n*Output, history, number interval=100\n\
           *Node Output, nset=INNER\n U1\n*End Step\n"
}

/// A listed mesh of skewed elements without parameters: Lamé's cylinder of radii 10 and 20 mm under 1 MPa, of which the
/// inner face moves by 9.53333e-5 mm. Bar: order 2 within 0.3, and the error within the uncertainty.
#[test]
fn listed_mesh_is_refined_with_the_order_of_its_elements() {
    let deck = lame_cylinder(4, 2);
    let source = |overrides: &ParameterOverrides| revolve::deck::read_text("lame.inp", &deck, overrides);
    let measure = Quantity::parse("mean(U1@INNER, 3.2e-4, 4e-4)").expect("a quantity");
    let axes = settings::axes(&["mesh=1,2,4".to_owned()], &[]).expect("levels");
    let exact = 9.533_333e-5;
    for given in [Some(exact), None] {
        let mut bench = StudyRunner::new(&source, &[], None, &measure, 1, &|| {});
        let study = refinement::grid(&mut bench, &axes, given).expect("a study");
        let row = study.rows.last().expect("rows");
        let value = row.value.expect("a value");
        match given {
            Some(_) => {
                let order = row.exact_orders[0].expect("an order");
                println!("order {order:.2}, error {:.1e}", value / exact - 1.0);
                assert!((order - 2.0).abs() < 0.3, "{order}");
            }
            None => assert!((value - exact).abs() < row.uncertainty.expect("an uncertainty")),
        }
    }
}

/// Bar: in 19 of 20 cases the true error of the finest level is within its grid convergence index.
#[test]
fn true_error_is_within_the_uncertainty() {
    let cases = cases::all();
    assert!(cases.len() >= 20);
    let mut outside = Vec::new();
    println!("{:<32} {:>10} {:>10} {:>10} {:>6}  behaviour", "case", "value", "error", "GCI", "order");
    for case in &cases {
        let study = study(case, false);
        let row = study.rows.last().expect("rows");
        let (value, estimate) =
            (row.value.expect("a value"), row.estimates.last().copied().flatten().expect("an estimate"));
        let (error, uncertainty) = (value - case.exact, row.uncertainty.expect("an uncertainty"));
        let order = estimate.order.map_or(String::new(), |o| format!("{o:.2}"));
        println!(
            "{:<32} {value:>10.4e} {error:>10.2e} {uncertainty:>10.2e} {order:>6}  {:?}",
            case.name, estimate.behaviour
        );
        if error.abs() > uncertainty {
            outside.push(case.name.as_str());
        }
    }
    println!("{} of {} within; outside: {outside:?}", cases.len() - outside.len(), cases.len());
    assert!(20 * outside.len() <= cases.len(), "{outside:?}");
}

/// Returns the relative error of a value, or the absolute one if the exact value is zero.
fn true_error(case: &StudyCase, value: f64) -> f64 {
    if case.exact == 0.0 { value.abs() } else { (value / case.exact - 1.0).abs() }
}

/// Bar: `--target`, without the exact value, finds a setting that meets it in every case, with at most twice the
/// element-cycles of the cheapest setting that meets it, if the series converges with a credible order. If it does not
/// (shocks, plastic shells), the study reports this and uses a larger margin; at most 4 of 26 cases then cost more.
#[test]
fn target_is_met_at_moderate_cost() {
    println!(
        "{:<32} {:>9} {:>9} {:>7} {:>10} {:>10} {:>6}",
        "case", "target", "error", "runs", "cycles", "least", "ratio"
    );
    let mut overpaid = 0;
    for case in cases::all() {
        let first = study(&case, true);
        let errors: Vec<f64> = first.rows.iter().map(|r| true_error(&case, r.value.expect("a value"))).collect();
        let aim = 0.2 * errors[0];
        let measure = Quantity::parse(&case.quantity).expect("a quantity");
        let axes = settings::axes(&[case.refine.to_owned()], &["n".to_owned()]).expect("levels");
        let mut bench = StudyRunner::new(&*case.deck, &[], None, &measure, 1, &|| {});
        let wanted = ErrorTarget { value: aim, relative: true };
        let (reached, met) = target::refine_to_target(&mut bench, &axes, None, wanted).expect("a study");
        let named = met.run.unwrap_or_else(|| panic!("{}: {aim:e} not reached", case.name));
        let row = &reached.rows[named];
        let error = true_error(&case, row.value.expect("a value"));
        let cycles = row.run.as_ref().expect("a run").element_cycles();
        // Coarser settings, closely spaced, up to the coarsest given one.
        let size = |value: &str| axes[0].size(value.parse().expect("a number"));
        let (mut least, mut coarser) = (cycles, size(&row.values[0]) * 1.15);
        while coarser <= axes[0].sizes[0] * 1.01 {
            let value = axes[0].value(coarser);
            let value = if axes[0].counts() { format!("{}", value.floor()) } else { format!("{value:e}") };
            let run = bench.at(&axes, &[value], None).expect("a run");
            if let revolve::study::quantity::QuantityValue::Number(found) = run.found
                && true_error(&case, found) <= aim
            {
                least = least.min(run.element_cycles());
            }
            coarser *= 1.15;
        }
        println!(
            "{:<32} {aim:>9.2e} {error:>9.2e} {:>7} {cycles:>10.3e} {least:>10.3e} {:>6.2}",
            case.name,
            reached.rows.len(),
            cycles / least
        );
        assert!(error <= aim, "{}: {error:e} above {aim:e}", case.name);
        let behaviours: Vec<ConvergenceBehaviour> =
            reached.rows.iter().flat_map(|r| &r.estimates).flatten().map(|e| e.behaviour).collect();
        let doubtful = |b: &ConvergenceBehaviour| {
            matches!(b, ConvergenceBehaviour::Slow | ConvergenceBehaviour::Oscillating | ConvergenceBehaviour::Fast)
        };
        let allowed = cycles <= 2.0 * least || behaviours.iter().any(doubtful);
        assert!(allowed, "{}: {cycles} against {least}, {behaviours:?}", case.name);
        overpaid += usize::from(cycles > 2.0 * least);
    }
    println!("overpaid: {overpaid}");
    assert!(overpaid <= 4, "{overpaid}");
}

/// Returns the refinement study of a deck in `tests/decks/studies` or `input`, or refines it to a target.
fn deck_study(
    deck: &str,
    refine: &str,
    quantity: &str,
    target: Option<&str>,
    jitter: usize,
) -> (RefinementStudy, Option<usize>) {
    let path = crate::common::project(deck);
    let source = |overrides: &ParameterOverrides| revolve::deck::read(&path, overrides);
    let model = revolve::model::build(&source(&[]).0).0;
    let measure = Quantity::parse(quantity).expect("a quantity");
    let axes = settings::axes(&[refine.to_owned()], &["n".to_owned()]).expect("levels");
    let mut bench = StudyRunner::new(&source, &[], None, &measure, 1, &|| {});
    let request = RefinementRequest {
        axes: &axes,
        exact: None,
        target: target.map(|text| ErrorTarget::parse(text).expect("a target")),
        noise: NoiseRequest::new(Some(jitter), &model),
        causes: causes::limits_of_order(&model),
        announce: &|_| {},
        around: false,
    };
    let completed = convergence::refine(&mut bench, &request).expect("a study");
    (completed.study, completed.target.and_then(|target| target.run))
}

/// Estimates the uncertainty of one run of a deck text.
fn certificate(name: &str, text: &str, quantity: &str, distributions: &[String]) -> RunCertificate {
    let source = |overrides: &ParameterOverrides| revolve::deck::read_text(name, text, overrides);
    let inputs = RandomInputs::parse(distributions, &[]).expect("distributions");
    let request = UncertaintyRequest {
        source: RunSource { deck: &source, user: None, interrupt: None },
        overrides: &[],
        traits: &ModelTraits::of(&revolve::model::build(&source(&[]).0).0),
        quantities: &[Quantity::parse(quantity).expect("a quantity")],
        inputs: (!inputs.names.is_empty()).then_some(&inputs),
        budget: 0.4,
    };
    uncertainty::run_and_estimate(&request).expect("a certificate")
}

/// Lamé's cylinder: the inner face moves by 9.53333e-5 mm. Bar: the error of a run is within its uncertainty, at a cost
/// of at most 40 %, and the mesh is the dominant part.
#[test]
fn uncertainty_of_one_run_contains_the_closed_form() {
    let found = certificate("lame.inp", &lame_cylinder(16, 8), "mean(U1@INNER, 3.2e-4, 4e-4)", &[]);
    println!("{}", found.conclusions.join("\n"));
    let quantity = &found.quantities[0];
    let (error, uncertainty) = (quantity.value - 9.533_333e-5, quantity.numerical().expect("a part"));
    assert!(error.abs() < uncertainty && uncertainty < 0.02 * quantity.value, "{error} {uncertainty}");
    assert_eq!((quantity.levels.len(), quantity.dominant, quantity.noise), (3, Some("mesh"), None));
    assert!(found.cost <= 0.4 && found.missing.is_empty(), "{}", found.cost);
}

/// Lamé's cylinder under a pressure that rises within its period, with 5 % more mass. Bar: the effect of mass scaling, from a mesh
/// of a sixteenth of the elements, is the change of the quantity without it within 5 %, and part of the sum.
#[test]
fn uncertainty_contains_the_effect_of_mass_scaling() {
    let plain = lame_cylinder(16, 8).replace("3.e-4, 1.", "2.e-5, 1.").replace(" , 4.e-4\n", " , 1.2e-5\n");
    let scaled = plain.replace(" , 1.2e-5\n", " , 1.2e-5\n*Fixed Mass Scaling, dt=1., budget=0.05\n");
    let [plain, scaled] = [plain, scaled].map(|deck| certificate("lame.inp", &deck, "final(U1@INNER)", &[]));
    println!("{}", scaled.conclusions.join("\n"));
    let quantity = &scaled.quantities[0];
    let effect = quantity.mass_scaling.expect("a part");
    let change = (quantity.value - plain.quantities[0].value).abs();
    assert!((effect / change - 1.0).abs() < 0.05 && change > 0.01 * quantity.value.abs(), "{effect} {change}");
    let parts = [quantity.mesh, quantity.increment, Some(effect)].into_iter().flatten().sum::<f64>();
    assert!((quantity.numerical().expect("parts") / parts - 1.0).abs() < 1e-12);
    assert_eq!(plain.quantities[0].mass_scaling, None);
}

/// Lamé's cylinder on a listed mesh. Bar: the run that is chosen for 0.5 % is within 0.5 % of the closed form, no coarser
/// than the second finest level, and the certificate has its levels. Without time no level is added, and the target is
/// not reached.
#[test]
fn chosen_mesh_meets_the_target_within_the_budget() {
    let text = lame_cylinder(8, 4);
    let source = |overrides: &ParameterOverrides| revolve::deck::read_text("lame.inp", &text, overrides);
    let choose = |seconds: u64| {
        let request = TargetRequest {
            source: RunSource { deck: &source, user: None, interrupt: None },
            overrides: &[],
            quantity: &Quantity::parse("mean(U1@INNER, 3.2e-4, 4e-4)").expect("a quantity"),
            target: ErrorTarget { value: 0.005, relative: true },
            budget: Duration::from_secs(seconds),
            announce: &|line| println!("{line}"),
        };
        chosen::choose(&request).expect("a setting")
    };
    let chosen = choose(600);
    println!("mesh = {}, increment = {}", chosen.mesh, chosen.increment);
    let error = chosen.quantity.value / 9.533_333e-5 - 1.0;
    assert!(chosen.reached && error.abs() < 0.005, "{error}");
    let levels: Vec<f64> = chosen.quantity.levels.iter().map(|level| level.size).collect();
    assert!(levels.len() >= 3 && levels.windows(2).all(|two| two[0] == 2.0 * two[1]), "{levels:?}");
    let named: f64 = chosen.mesh.parse().expect("a factor");
    let finest = chosen.study["runs"].as_array().expect("runs").len() as i32 - 3;
    assert!(named >= 2.0_f64.powi(finest - 1), "{named}");
    assert!(!choose(0).reached);
}

/// A rigid ogive at 800 m/s with a standard deviation of 8 m/s. Reference: central difference of the closed form of a
/// fully embedded nose. Bar: the 95 % interval of the depth within 5 % (the entry phase is not in the closed form).
#[test]
fn random_velocity_dominates_the_uncertainty_of_a_shot() {
    let text = crate::common::ogive();
    let found = certificate("ogive.inp", &text, "-final(U2@REF)", &["V=normal(800, 8)".to_owned()]);
    println!("{}", found.conclusions.join("\n"));
    let quantity = &found.quantities[0];
    let depth = |v: f64| cases::closed_form(v, [1.0, 0.0, 0.106_481_481], 0.0);
    let expected = 1.959_964 * 0.5 * (depth(808.0) - depth(792.0));
    let input = quantity.input.expect("an input part");
    assert!((input / expected - 1.0).abs() < 0.05, "{input} {expected}");
    assert_eq!(quantity.dominant, Some("input"));
}

/// Two elastic bars of different impedance: displacements of the far ends at 0.1 ms by the method of characteristics
/// (200 000 intervals of time). Linear bulk viscosity smears the fronts. Bar: the errors are within the uncertainty.
#[test]
fn smeared_wave_fronts_are_within_the_uncertainty() {
    for (quantity, exact) in [("final(U2@SA)", 0.234_602), ("final(U2@UC)", 0.493_055)] {
        for refine in ["n=10,20,40", "n=20,40,80", "n=16,24,36"] {
            let (study, _) = deck_study("tests/decks/studies/unequal_bars.inp", refine, quantity, None, 0);
            let row = study.rows.last().expect("rows");
            let (error, uncertainty) = (row.value.expect("a value") - exact, row.uncertainty.expect("an uncertainty"));
            println!("{quantity} {refine}: error {error:.2e}, uncertainty {uncertainty:.2e}");
            assert!(error.abs() < uncertainty, "{quantity} {refine}: {error} {uncertainty}");
        }
    }
}

/// Upsetting between rough plates: the corners are singular, and the work converges with an order below 1. Reference:
/// 146.3 J, given with the deck; meshes up to n = 128 give 146.1 J. Bar: the setting that `--target` names is within the target, and no coarser
/// than the second finest level.
#[test]
fn target_is_met_with_singular_corners() {
    let (study, named) = deck_study("tests/decks/studies/upset.inp", "n=4,8", "final(ALLWK)", Some("2%"), 0);
    let named = named.expect("a setting");
    let error = study.rows[named].value.expect("a value") / 146.3e3 - 1.0;
    println!("{:?} of {}: error {error:.2e}", study.rows[named].values, study.rows.len());
    assert!(error.abs() < 0.02, "{error}");
    assert!(named + 2 >= study.series[0].rows.len(), "{named}");
}

/// Rod through a plate with failure: the final velocity of a node scatters by more than the perturbations, its average
/// over the last third less than half as much. Bar: no uncertainty is below the noise. An elastic wave does not amplify perturbations.
#[test]
fn noise_of_an_eroding_model_limits_the_uncertainty() {
    let eroding = || deck_study("input/rod_plate_deletion.inp", "mesh=1/2,1", "final(V2@TAIL)", None, 8).0;
    let study = eroding();
    let noise = study.noise.as_ref().expect("noise");
    println!("{noise:?}");
    assert!(noise.relative.expect("a value") > 1e-3 && noise.divergence != Divergence::Absent);
    assert!(noise.better.as_ref().expect("an average").relative < 0.5 * noise.relative.expect("a value"));
    assert!(study.rows.iter().filter_map(|r| r.uncertainty).all(|u| u >= noise.uncertainty));
    assert_eq!(eroding().noise.expect("noise"), *noise);
    let upset = deck_study("tests/decks/studies/upset.inp", "n=2,4", "final(ALLWK)", None, 4).0;
    assert_eq!(upset.noise.expect("noise").divergence, Divergence::Absent);
}

/// A field compared with the finest mesh, without an exact value: nodes and elements of the standing wave, order 2.
#[test]
fn fields_converge_against_the_finest_mesh() {
    for quantity in ["norm(V2)", "norm(S22)"] {
        let case = StudyCase { quantity: quantity.into(), refine: "n=10,20,40,80", ..cases::wave_in_space() };
        let study = study(&case, false);
        let row = study.rows.last().expect("rows");
        let order = row.estimates.last().copied().flatten().and_then(|e| e.order).expect("an order");
        let error = row.error.expect("an error").abs();
        println!("{quantity}: order {order:.3}, error of the finest {error:.2e}");
        assert!((order - 2.0).abs() < 0.1, "{quantity}: {order}");
        // The true error of the field on 80 elements is 5.2e-4, which the study estimates without the exact solution.
        assert!(quantity != "norm(V2)" || (error / 5.2e-4 - 1.0).abs() < 0.05, "{error:e}");
    }
}

/// The files of a study, their keys, and the exit status if a target cannot be met.
/// Numbers of elements that decrease are read as sizes; the warning names the level that counts as the finest.
#[test]
fn levels_from_fine_to_coarse_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let words = ["study", "input/ogive.inp", "--quantity", "final(U2@REF)", "--repeat", "1", "--out", out];
    let message = |levels: &str| {
        let output = crate::common::revolve(&[&words[..], &["--refine", levels]].concat());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let reversed = message("n=40,20,10");
    assert!(
        reversed.contains("n = 10 is taken as the finest level") && reversed.contains("n = 40 has 40"),
        "{reversed}"
    );
    assert!(!message("n=10,20,40").contains("is taken as"));
}

#[test]
fn study_command_writes_all_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let study = |more: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(["study", "input/ogive.inp", "--refine", "n=10,20", "--repeat", "1"])
            .args(["--quantity", "-1000*final(U2@REF)", "--out", folder.path().to_str().expect("a name")])
            .args(more)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("the program runs");
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let keys = || -> Vec<String> {
        let text = std::fs::read_to_string(folder.path().join("ogive_study.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        record.as_object().expect("an object").keys().cloned().collect()
    };
    let (status, printed) = study(&["--refine", "load-velocity=predicted,lagged"]);
    assert_eq!(status, Some(0));
    assert!(printed.contains(" takes ") && printed.contains("limit "), "{printed}");
    let expected =
        ["quantity", "reference", "scale", "runs", "refinements", "front", "prices", "sentence", "timing", "version"];
    assert_eq!(keys(), expected);
    let csv = std::fs::read_to_string(folder.path().join("ogive_study.csv")).expect("a table");
    assert!(csv.starts_with("n,load-velocity,value,error %,error below %,order,limit,GCI %,increments,"), "{csv}");
    assert_eq!(csv.lines().count(), 5);
    for picture in ["ogive_study.png", "ogive_study.svg", "ogive_study_order.png", "ogive_study_order.svg"] {
        assert!(std::fs::metadata(folder.path().join(picture)).expect("a picture").len() > 2000, "{picture}");
    }
    assert_eq!(study(&["--target", "0.01%"]).0, Some(0));
    assert!(keys().contains(&"target".to_owned()));
    // Far below the error of the increments.
    assert_eq!(study(&["--target", "1e-12%", "--quiet"]), (Some(1), String::new()));
    // Order 2 is confirmed by the given mesh and two coarser ones: no finer mesh is run.
    let around = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args(["study", "input/ogive.inp", "--around", "--quiet", "--repeat", "1", "--quantity", "-final(U2@REF)"])
        .args(["--out", folder.path().to_str().expect("a name")])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program runs");
    assert_eq!(around.status.code(), Some(0));
    let csv = std::fs::read_to_string(folder.path().join("ogive_study.csv")).expect("a table");
    let levels: Vec<&str> = csv.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(levels, ["0.25", "0.5", "1"]);
    let run = |target: &str| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(["run", "input/ogive.inp", "--quiet", "--no-frames", "--quantity", "-1000*final(U2@REF)"])
            .args(["--target", target, "--out", folder.path().to_str().expect("a name")])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("the program runs");
        let text = std::fs::read_to_string(folder.path().join("ogive_certificate.json")).expect("a certificate");
        let certificate: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        (output.status.code(), certificate["target"]["reached"].as_bool())
    };
    assert_eq!(run("0.1%"), (Some(0), Some(true)));
    assert_eq!(run("1e-12%"), (Some(1), Some(false)));
    assert_eq!(study(&["--ablate"]).0, Some(0));
    assert_eq!(keys(), ["quantity", "ablation", "version"]);
}
