//! Runs that cannot give a valid result halt with increment and time.

use revolve::solve::Instant;
use revolve::user::{AnalysisMoment, LoadFailure, LoadPoints, Routines, RunAction, UserEvents, UserLoad};

use crate::common::solid::{grid, material};
use crate::scene::{GauntletRun, text, with};
use crate::{CaseVerdict, cases};

cases! { "Guard rails":
    a_face_that_passes_its_opposite, "element compressed to zero volume by a prescribed motion",
        "halted (R209 or R206) with element, increment and time, volume decreases by at most 20 % an increment";
    a_first_increment_faster_than_sound, "block against a fixed face at 2.5 times its speed of sound: an element loses half of its volume before rates are known",
        "completed, or halted with a location; the first increment removes less than 20 % of the volume of any element";
    an_increment_beyond_stability, "fixed increment twice the stable one: created energy",
        "*ENERGY LIMIT, ERROR, ACTION=HALT: halted (R208) with increment and time";
    energy_of_nothing_halts_every_run, "increment 1.8 times the stable one in a deck without energy limits; body that reverses within increments",
        "halted (R208) with element, start time, cause and card, after a warning of negative ALLKE; continues with *ENERGY LIMIT, ERROR=1e8, with a drift above 20 %";
    a_closed_path_that_gives_energy, "elastic element on a large closed strain path, repeated: stress rates without a potential create energy although ETOTAL is balanced",
        "one warning of negative ALLIE during the run, with increment and time; none for the reversed path, which dissipates energy";
    an_increment_that_crawls, "increment so small that 1e9 remain: a run of days without a message",
        "one warning during the run with the remaining increments; none for the same block at its stable increment";
    shells_that_burst, "a clamped plate of shells bursts under a pressure: 60 times as many increments remain as were expected",
        "one warning during the run with the expected increments and the element";
    an_element_that_collapses, "one squashed element makes the increment of the whole model 50 times smaller",
        "warning during the run with element, material, factor, remaining increments and cards, and one at the end with the share of the increments; none if a layer of elements is compressed, or if the element is squashed at the end";
    a_pattern_that_grows, "kinetic energy in the hourglass modes",
        "warning during the run with the element; none for a bar in one long wave";
    too_much_hourglassing, "coarse mesh dominated by hourglass control",
        "*ENERGY LIMIT, ARTIFICIAL: one warning and a complete run; with HALT, R208";
    forces_without_bound, "forces and velocities near the largest floating-point number: propagating infinities",
        "each halted with a code and a name or increment";
    user_answers_without_bound, "user subroutine that returns infinity or NaN, on rigid and deformable faces",
        "each halted (R201) with surface, point, increment and time";
}

const END: &str = "*Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n";

fn block(speed: &str, step: &str) -> GauntletRun {
    let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(100.0, 0.3, 1.0, "")
        + speed
        + "*Step\n"
        + step
        + END;
    text(&deck, &Routines::none())
}

fn halt(scene: &GauntletRun) -> (&'static str, String) {
    scene.outcome.halt.as_ref().map_or(("completed", String::new()), |h| (h.code(), h.message().to_owned()))
}

fn contains_all(reason: &str, words: &[&str]) -> bool {
    words.iter().all(|w| reason.contains(w))
}

fn a_face_that_passes_its_opposite() -> CaseVerdict {
    let scene = block(
        "",
        "*Dynamic, Explicit\n , 4.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, -1.\n",
    );
    let (code, reason) = halt(&scene);
    println!("{reason}");
    let holds = ["R206", "R209"].contains(&code) && contains_all(&reason, &["element", "increment", "time"]);
    CaseVerdict { figure: code.into(), holds }
}

fn a_first_increment_faster_than_sound() -> CaseVerdict {
    // The speed of sound is about 12 here.
    let scene = block(
        "*Initial Conditions, type=VELOCITY\n ALL, 2, -30.\n",
        "*Dynamic, Explicit\n , 0.02\n*Boundary\n I0, 1, 1\n J0, 2, 2\n",
    );
    let (code, reason) = halt(&scene);
    println!("{reason}");
    // The strain rate of the lowest row is 30.
    let smallest = scene.outcome.steps[0].smallest_increment;
    let holds = smallest < 0.2 / 30.0 * 1.000_001
        && (code == "completed" || contains_all(&reason, &["element", "increment", "time"]));
    CaseVerdict { figure: code.into(), holds }
}

fn an_increment_beyond_stability() -> CaseVerdict {
    let free = block(
        "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n",
        "*Dynamic, Explicit\n , 1.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n",
    );
    // The estimate is conservative: twice its increment exceeds the stability limit of any mesh.
    let dt = 2.0 * free.outcome.steps[0].smallest_increment;
    let step = format!(
        "*Dynamic, Explicit, direct user control\n {dt:e}, 100.\n*Energy Limit, error=0.01, action=HALT\n*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n"
    );
    let (code, reason) = halt(&block("*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n", &step));
    println!("{reason}");
    CaseVerdict {
        figure: code.into(),
        holds: code == "R208" && contains_all(&reason, &["energy drift", "increment", "time"]),
    }
}

/// Returns a free plastic block, run at 1.8 times its stable time increment.
fn beyond(more: &str) -> GauntletRun {
    let deck = grid(4, 4, false, |i, j| [i as f64, j as f64])
        + &material(100.0, 0.3, 1.0, "*Plastic\n 1., 0.\n 1.1, 1.\n")
        + "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n*Step\n"
        + "*Dynamic, Explicit, direct user control\n 0.095166, 190.332\n"
        + more
        + "*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n"
        + END;
    text(&deck, &Routines::none())
}

fn energy_of_nothing_halts_every_run() -> CaseVerdict {
    let (scene, reported) = (beyond(""), beyond("*Energy Limit, error=1.e8\n"));
    let (code, reason) = halt(&scene);
    println!("{reason}\n{:?}\n{} {:?}", scene.outcome.warnings, reported.outcome.energy.drift, reported.outcome.halt);
    let located =
        contains_all(&reason, &["element", "increment", "time", "since time", "DIRECT USER CONTROL", "*ENERGY LIMIT"]);
    let negative = scene.outcome.warnings.iter().any(|w| w.starts_with("R303: ALLKE is -"));
    let continues = reported.outcome.increments > scene.outcome.increments && reported.outcome.energy.drift > 0.2;
    CaseVerdict {
        figure: code.into(),
        holds: code == "R208" && located && negative && continues && halt(&reported).0 != "R208",
    }
}

/// Returns an element far from the axis whose upper edge is moved around a square `turns` times, first along z or first
/// along r.
fn around(turns: usize, first_up: bool) -> GauntletRun {
    let mut texts = [String::from(" 0., 1.\n"), String::from(" 0., 0.\n")];
    for leg in 0..4 * turns {
        let (end, next) = (10.0 * (leg + 1) as f64, (leg + 1) % 4);
        for (text, values) in texts.iter_mut().zip([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]]) {
            *text += &format!(" {}, {}\n {}, {}\n", end - 0.5, values[leg % 4], end + 0.5, values[next]);
        }
    }
    let [up, side] = if first_up { [2, 1] } else { [1, 2] };
    let deck = grid(1, 1, false, |i, j| [1000.0 + i as f64, j as f64])
        + &material(100.0, 0.3, 1.0, "")
        + &format!("*Amplitude, name=FIRST\n{}*Amplitude, name=SECOND\n{}", texts[0], texts[1])
        + &format!("*Step\n*Dynamic, Explicit\n , {}\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J0, 1, 2\n", 40 * turns)
        + &format!("*Boundary, type=VELOCITY, amplitude=FIRST\n J1, {up}, {up}, 0.06\n")
        + &format!("*Boundary, type=VELOCITY, amplitude=SECOND\n J1, {side}, {side}, 0.06\n")
        + END;
    text(&deck, &Routines::none())
}

fn a_closed_path_that_gives_energy() -> CaseVerdict {
    let scenes = [around(5, true), around(5, false)];
    let reported = scenes.each_ref().map(|scene| {
        println!("{:?} {:?}", scene.outcome.energy, scene.outcome.warnings);
        scene
            .outcome
            .warnings
            .iter()
            .filter(|w| w.starts_with("R303: ALLIE is -") && contains_all(w, &["increment", "time"]))
            .count()
    });
    CaseVerdict {
        figure: format!("{} and {} times", reported[0], reported[1]),
        holds: reported.iter().sum::<usize>() == 1,
    }
}

/// Ends a run after a number of increments.
struct IncrementBudget(u64);

impl UserEvents for IncrementBudget {
    fn moment(&mut self, _: AnalysisMoment, now: &Instant, _: f64) -> Result<RunAction, LoadFailure> {
        Ok(if now.increment < self.0 { RunAction::Continue } else { RunAction::EndAnalysis })
    }
}

fn an_increment_that_crawls() -> CaseVerdict {
    let run = |length: &str| {
        // The user subroutine ends the run.
        let step = format!("*Dynamic, Explicit, direct user control\n 1.e-9, {length}\n*Boundary\n I0, 1, 1\n");
        let deck =
            grid(2, 2, false, |i, j| [i as f64, j as f64]) + &material(100.0, 0.3, 1.0, "") + "*Step\n" + &step + END;
        text(&deck, &Routines::none().with_events(IncrementBudget(4096)))
    };
    let reported = |scene: &GauntletRun| {
        scene.outcome.warnings.iter().filter(|w| w.starts_with("R306: the run advances slowly")).count()
    };
    let (slow, quick) = (run("1."), run("1.e-3"));
    println!("{:?}", slow.outcome.warnings);
    let named = slow
        .outcome
        .warnings
        .iter()
        .any(|w| contains_all(w, &["1.0e9 increments remain", "increment", "time", "DIRECT USER CONTROL"]));
    CaseVerdict {
        figure: format!("{} and {} times", reported(&slow), reported(&quick)),
        holds: named && (reported(&slow), reported(&quick)) == (1, 0),
    }
}

/// A clamped plate of 20 shells under a pressure that bursts it: necking takes the increment far below that at the start.
fn shells_that_burst() -> CaseVerdict {
    let deck = "*Node, nset=AXIS\n 1, 0., 0.\n*Node, nset=RIM\n 21, 0.2, 0.\n*Ngen\n 1, 21, 1\n\
        *Element, type=SAX1, elset=PLATE\n 1, 1, 2\n*Elgen, elset=PLATE\n 1, 20, 1, 1\n\
        *Shell Section, elset=PLATE, material=STEEL\n 2.e-3,\n*Material, name=STEEL\n*Density\n 7850.,\n\
        *Elastic\n 200.e9, 0.3\n*Plastic\n 300.e6, 0.\n 500.e6, 0.5\n\
        *Step\n*Dynamic, Explicit\n , 3.e-3\n*Boundary\n AXIS, 1, 1\n AXIS, 6, 6\n RIM, ENCASTRE\n*Dload\n PLATE, P, 5.e6\n*End Step\n";
    let scene = text(deck, &Routines::none().with_events(IncrementBudget(12_000)));
    let found: Vec<_> =
        scene.outcome.warnings.iter().filter(|w| w.starts_with("R306: the run advances slowly")).collect();
    println!("{found:?}");
    let named = |w: &&String| contains_all(w, &["at its start 2.2e3 were expected", "limited by element"]);
    CaseVerdict { figure: format!("{} times", found.len()), holds: found.len() == 1 && found.iter().all(named) }
}

fn an_element_that_collapses() -> CaseVerdict {
    // The nodes from 56 on approach those below.
    let run = |card: &str, count: usize, path: &str| {
        let deck = grid(10, 10, false, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.0, 1.0, "*Plastic\n 0.1, 0.\n")
            + card
            + &format!("*Nset, nset=LOWER, generate\n 45, {}, 1\n", 44 + count)
            + &format!("*Nset, nset=UPPER, generate\n 56, {}, 1\n", 55 + count)
            + &format!("*Amplitude, name=A, definition=SMOOTH STEP\n{path}\n")
            + "*Step\n*Dynamic, Explicit, element by element\n , 100.\n*Boundary\n J0, 2, 2\n LOWER, 2, 2\n"
            + "*Boundary, amplitude=A\n UPPER, 2, 2, -0.98\n"
            + END;
        text(&deck, &Routines::none()).outcome.warnings
    };
    let keeps = "*Remesh, automatic=NO\n";
    let squashed = run(keeps, 2, " 0., 0., 20., 1.");
    let layer = run(keeps, 11, " 0., 0., 20., 1.");
    let late = run(keeps, 2, " 0., 0., 99., 0., 100., 1.");
    let [during, end] = ["the time increment collapses", "of the increments"].map(|begins| {
        let found: Vec<&String> = squashed.iter().filter(|w| w.contains(begins) && w.contains("material M")).collect();
        println!("{found:?}");
        found.len()
    });
    let words = ["element 41 ", "by a factor of", "increments remain", "*EROSION, INCREMENT=", "TYPE=BELOW MIN"];
    let named = squashed.iter().any(|w| contains_all(w, &words));
    let silent = [&layer, &late].iter().all(|list| list.iter().all(|w| !w.contains("collapses")));
    CaseVerdict { figure: format!("{during} and {end}"), holds: named && silent && (during, end) == (1, 2) }
}

fn a_pattern_that_grows() -> CaseVerdict {
    // Almost no hourglass control, and nodal forces of alternating sign at the frequency of the pattern, whose
    // amplitude therefore grows.
    let body = |controls: &str, push: &str| {
        let place = |i: usize, j: usize| [i as f64, j as f64];
        let section = material(100.0, 0.3, 1.0, "").replacen("material=M", "material=M, controls=C", 1);
        let deck = grid(6, 6, false, place)
            + controls
            + &section
            + "*Step\n*Dynamic, Explicit\n , 40.\n*Boundary\n J0, 2, 2\n"
            + push
            + END;
        text(&deck, &Routines::none())
    };
    let weak = "*Section Controls, name=C, hourglass=STIFFNESS\n 1.e-6,\n";
    let alternating: String =
        (0..49).map(|n| format!(" {}, 2, {}\n", n + 1, if (n % 7 + n / 7) % 2 == 0 { 0.01 } else { -0.01 })).collect();
    let vibrating = body(weak, &format!("*Cload\n{alternating}"));
    let whole = body("*Section Controls, name=C, hourglass=ENHANCED\n 1.,\n", "*Dsload\n J1, P, 0.01\n");
    let reported = |scene: &GauntletRun| {
        scene.outcome.warnings.iter().any(|w| contains_all(w, &["pattern grows", "element", "increment", "time"]))
    };
    println!("{:?}\n{:?}", vibrating.outcome.warnings, whole.outcome.warnings);
    let (one, other) = (reported(&vibrating), reported(&whole));
    CaseVerdict { figure: if one { "warning issued".into() } else { "no warning".into() }, holds: one && !other }
}

fn too_much_hourglassing() -> CaseVerdict {
    let run = |action: &str| {
        block(
            "",
            &format!(
                "*Dynamic, Explicit\n , 2.\n*Energy Limit, artificial=0.01, action={action}\n*Boundary\n I0, 1, 1\n J0, 2, 2\n*Cload\n 9, 2, -1.\n"
            ),
        )
    };
    let (warned, halted) = (run("WARN"), run("HALT"));
    let (code, reason) = halt(&halted);
    println!("{:?}; {reason}", warned.outcome.warnings);
    let holds = warned.outcome.halt.is_none() && warned.outcome.warnings.len() == 1 && code == "R208";
    CaseVerdict {
        figure: format!("{} warning; {code}", warned.outcome.warnings.len()),
        holds: holds && contains_all(&reason, &["artificial"]),
    }
}

fn forces_without_bound() -> CaseVerdict {
    let held = "*Dynamic, Explicit\n , 1.\n*Boundary\n I0, 1, 1\n J0, 2, 2\n";
    let scenes = [
        block("", &format!("{held}*Cload\n 9, 2, 1.e300\n")),
        block("", &format!("{held}*Dsload\n J1, P, 1.e300\n")),
        block("*Initial Conditions, type=VELOCITY\n 9, 2, 1.e200\n", held),
        with("disc.inp", &[("mass", "1.e-300")], &Routines::none().with_load(ConstantPressure(1e300))),
    ];
    let halts: Vec<_> = scenes.iter().map(halt).collect();
    halts.iter().for_each(|h| println!("{}: {}", h.0, h.1));
    let holds = halts.iter().all(|(code, reason)| code.starts_with('R') && contains_all(reason, &["increment"]));
    CaseVerdict { figure: halts.iter().map(|h| h.0).collect::<Vec<_>>().join(", "), holds }
}

struct ConstantPressure(f64);

impl UserLoad for ConstantPressure {
    fn pressure(&mut self, _: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(self.0);
        Ok(())
    }
}

fn user_answers_without_bound() -> CaseVerdict {
    let deforming = |value: f64| {
        let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.3, 1.0, "")
            + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n I0, 1, 1\n J0, 2, 2\n*Dsload\n J1, PNU\n"
            + END;
        text(&deck, &Routines::none().with_load(ConstantPressure(value)))
    };
    let rigid = |value: f64| with("disc.inp", &[], &Routines::none().with_load(ConstantPressure(value)));
    let mut holds = true;
    for value in [f64::INFINITY, f64::NAN] {
        for (scene, surface) in [(deforming(value), "J1"), (rigid(value), "FACE")] {
            let (code, reason) = halt(&scene);
            println!("{code}: {reason}");
            holds &= code == "R201" && contains_all(&reason, &[surface, "point", "increment", "time"]);
        }
    }
    CaseVerdict { figure: if holds { "R201 each".into() } else { "not located".into() }, holds }
}
