//! Guard rails: what cannot be answered halts with a place.

use revolve::solve::Instant;
use revolve::user::{AnalysisMoment, LoadFailure, LoadPoints, Routines, RunAction, UserEvents, UserLoad};

use crate::common::solid::{grid, material};
use crate::scene::{Scene, text, with};
use crate::{Verdict, cases};

cases! { "Guard rails":
    a_face_that_passes_its_opposite, "an element pressed to nothing by a motion that is given",
        "halted (R209 or R206) with element, increment and time, volume lost in steps of 20 %";
    a_first_increment_faster_than_sound, "a block that meets a held face at 2.5 times its speed of sound: half of an element is lost before any rate is known",
        "completed or located halt; the first increment takes less than 20 % of any element";
    an_increment_beyond_stability, "a fixed increment twice the stable one: energy of nothing",
        "*ENERGY LIMIT, ERROR, ACTION=HALT: halted (R208) with increment and time";
    energy_of_nothing_halts_every_run, "an increment 1.8 times the stable one in a deck without a word on energies; a body that turns around within increments",
        "halted (R208) with element, since when, cause and card, ALLKE below zero told before; *ENERGY LIMIT, ERROR=10 lets it go on, with a drift above 20 %";
    a_closed_path_that_gives_energy, "an elastic element led around a large closed path again and again: rates of stress that have no potential give energy out of nothing, and ETOTAL closes all the same",
        "ALLIE below zero is told once while the run goes on, with increment and time; the other way around, where the path takes energy, nothing is";
    an_increment_that_crawls, "an increment that leaves 1e9 to go: nothing is told for days",
        "told once while the run goes on, with the increments to go; the same block at its stable increment is silent";
    a_pattern_that_grows, "kinetic energy that goes into the hourglass pattern",
        "told while the run goes on, with the element; a bar in one long wave is silent";
    too_much_hourglassing, "a coarse mesh that lives by its hourglass control",
        "*ENERGY LIMIT, ARTIFICIAL: one warning and the end of the run; with HALT, R208";
    forces_without_bound, "forces and velocities near the end of floating point: infinities that run on",
        "each halted with a code and a name or an increment";
    user_answers_without_bound, "a routine that answers infinity or no number, on rigid and deformable faces",
        "each halted (R201) with surface, point, increment and time";
}

const END: &str = "*Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n";

fn block(speed: &str, step: &str) -> Scene {
    let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(100.0, 0.3, 1.0, "")
        + speed
        + "*Step\n"
        + step
        + END;
    text(&deck, &Routines::none())
}

fn halt(scene: &Scene) -> (&'static str, String) {
    scene.outcome.halt.as_ref().map_or(("completed", String::new()), |h| (h.code, h.reason.clone()))
}

fn says(reason: &str, words: &[&str]) -> bool {
    words.iter().all(|w| reason.contains(w))
}

fn a_face_that_passes_its_opposite() -> Verdict {
    let scene = block(
        "",
        "*Dynamic, Explicit\n , 4.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, -1.\n",
    );
    let (code, reason) = halt(&scene);
    println!("{reason}");
    let holds = ["R206", "R209"].contains(&code) && says(&reason, &["element", "increment", "time"]);
    Verdict { figure: code.into(), holds }
}

fn a_first_increment_faster_than_sound() -> Verdict {
    // Sound runs at about 12 here.
    let scene = block(
        "*Initial Conditions, type=VELOCITY\n ALL, 2, -30.\n",
        "*Dynamic, Explicit\n , 0.02\n*Boundary\n I0, 1, 1\n J0, 2, 2\n",
    );
    let (code, reason) = halt(&scene);
    println!("{reason}");
    // The rate of the lowest row is 30 a length of 1.
    let smallest = scene.outcome.steps[0].smallest_increment;
    let holds =
        smallest < 0.2 / 30.0 * 1.000_001 && (code == "completed" || says(&reason, &["element", "increment", "time"]));
    Verdict { figure: code.into(), holds }
}

fn an_increment_beyond_stability() -> Verdict {
    let free = block(
        "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n",
        "*Dynamic, Explicit\n , 1.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n",
    );
    // The bound is not sharp: twice what it allows is beyond the highest frequency of any mesh.
    let dt = 2.0 * free.outcome.steps[0].smallest_increment;
    let step = format!(
        "*Dynamic, Explicit, direct user control\n {dt:e}, 100.\n*Energy Limit, error=0.01, action=HALT\n*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n"
    );
    let (code, reason) = halt(&block("*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n", &step));
    println!("{reason}");
    Verdict { figure: code.into(), holds: code == "R208" && says(&reason, &["energy drift", "increment", "time"]) }
}

/// A free block that flows, under 1.8 times the increment that its elements bear.
fn beyond(more: &str) -> Scene {
    let deck = grid(4, 4, false, |i, j| [i as f64, j as f64])
        + &material(100.0, 0.3, 1.0, "*Plastic\n 1., 0.\n 1.1, 1.\n")
        + "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-3\n*Step\n"
        + "*Dynamic, Explicit, direct user control\n 0.095166, 190.332\n"
        + more
        + "*Bulk Viscosity\n 0., 0.\n*Boundary\n I0, 1, 1\n"
        + END;
    text(&deck, &Routines::none())
}

fn energy_of_nothing_halts_every_run() -> Verdict {
    let (scene, told) = (beyond(""), beyond("*Energy Limit, error=10.\n"));
    let (code, reason) = halt(&scene);
    println!("{reason}\n{:?}\n{} {:?}", scene.outcome.warnings, told.outcome.energy.drift, told.outcome.halt);
    let located =
        says(&reason, &["element", "increment", "time", "since time", "DIRECT USER CONTROL", "*ENERGY LIMIT"]);
    let negative = scene.outcome.warnings.iter().any(|w| w.starts_with("ALLKE is -"));
    let goes_on = told.outcome.increments > scene.outcome.increments && told.outcome.energy.drift > 0.2;
    Verdict { figure: code.into(), holds: code == "R208" && located && negative && goes_on && halt(&told).0 != "R208" }
}

/// An element far from the axis whose upper edge is led around a square, so many times, first along z or first along r.
fn around(turns: usize, first_up: bool) -> Scene {
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

fn a_closed_path_that_gives_energy() -> Verdict {
    let scenes = [around(5, true), around(5, false)];
    let told = scenes.each_ref().map(|scene| {
        println!("{:?} {:?}", scene.outcome.energy, scene.outcome.warnings);
        scene.outcome.warnings.iter().filter(|w| w.starts_with("ALLIE is -") && says(w, &["increment", "time"])).count()
    });
    Verdict { figure: format!("{} and {} times", told[0], told[1]), holds: told.iter().sum::<usize>() == 1 }
}

/// Ends a run after some thousand increments.
struct Enough;

impl UserEvents for Enough {
    fn moment(&mut self, _: AnalysisMoment, now: &Instant, _: f64) -> Result<RunAction, LoadFailure> {
        Ok(if now.increment < 4096 { RunAction::Continue } else { RunAction::EndAnalysis })
    }
}

fn an_increment_that_crawls() -> Verdict {
    let run = |length: &str| {
        // The run is ended from outside: its routine wants no more.
        let step = format!("*Dynamic, Explicit, direct user control\n 1.e-9, {length}\n*Boundary\n I0, 1, 1\n");
        let deck =
            grid(2, 2, false, |i, j| [i as f64, j as f64]) + &material(100.0, 0.3, 1.0, "") + "*Step\n" + &step + END;
        text(&deck, &Routines::none().with_events(Enough))
    };
    let told =
        |scene: &Scene| scene.outcome.warnings.iter().filter(|w| w.starts_with("the run advances slowly")).count();
    let (slow, quick) = (run("1."), run("1.e-3"));
    println!("{:?}", slow.outcome.warnings);
    let named = slow
        .outcome
        .warnings
        .iter()
        .any(|w| says(w, &["1.0e9 increments remain", "increment", "time", "DIRECT USER CONTROL"]));
    Verdict {
        figure: format!("{} and {} times", told(&slow), told(&quick)),
        holds: named && (told(&slow), told(&quick)) == (1, 0),
    }
}

fn a_pattern_that_grows() -> Verdict {
    // Next to no control, and a push at every other node that turns around each half period of nothing else: it only grows.
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
    let trembling = body(weak, &format!("*Cload\n{alternating}"));
    let whole = body("*Section Controls, name=C, hourglass=ENHANCED\n 1.,\n", "*Dsload\n J1, P, 0.01\n");
    let told = |scene: &Scene| {
        scene.outcome.warnings.iter().any(|w| says(w, &["pattern grows", "element", "increment", "time"]))
    };
    println!("{:?}\n{:?}", trembling.outcome.warnings, whole.outcome.warnings);
    let (one, other) = (told(&trembling), told(&whole));
    Verdict { figure: if one { "told".into() } else { "silent".into() }, holds: one && !other }
}

fn too_much_hourglassing() -> Verdict {
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
    Verdict {
        figure: format!("{} warning; {code}", warned.outcome.warnings.len()),
        holds: holds && says(&reason, &["artificial"]),
    }
}

fn forces_without_bound() -> Verdict {
    let held = "*Dynamic, Explicit\n , 1.\n*Boundary\n I0, 1, 1\n J0, 2, 2\n";
    let scenes = [
        block("", &format!("{held}*Cload\n 9, 2, 1.e300\n")),
        block("", &format!("{held}*Dsload\n J1, P, 1.e300\n")),
        block("*Initial Conditions, type=VELOCITY\n 9, 2, 1.e200\n", held),
        with("disc.inp", &[("mass", "1.e-300")], &Routines::none().with_load(Constant(1e300))),
    ];
    let halts: Vec<_> = scenes.iter().map(halt).collect();
    halts.iter().for_each(|h| println!("{}: {}", h.0, h.1));
    let holds = halts.iter().all(|(code, reason)| code.starts_with('R') && says(reason, &["increment"]));
    Verdict { figure: halts.iter().map(|h| h.0).collect::<Vec<_>>().join(", "), holds }
}

struct Constant(f64);

impl UserLoad for Constant {
    fn pressure(&mut self, _: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(self.0);
        Ok(())
    }
}

fn user_answers_without_bound() -> Verdict {
    let deforming = |value: f64| {
        let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.3, 1.0, "")
            + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n I0, 1, 1\n J0, 2, 2\n*Dsload\n J1, PNU\n"
            + END;
        text(&deck, &Routines::none().with_load(Constant(value)))
    };
    let rigid = |value: f64| with("disc.inp", &[], &Routines::none().with_load(Constant(value)));
    let mut holds = true;
    for value in [f64::INFINITY, f64::NAN] {
        for (scene, surface) in [(deforming(value), "J1"), (rigid(value), "FACE")] {
            let (code, reason) = halt(&scene);
            println!("{code}: {reason}");
            holds &= code == "R201" && says(&reason, &[surface, "point", "increment", "time"]);
        }
    }
    Verdict { figure: if holds { "R201 each".into() } else { "not located".into() }, holds }
}
