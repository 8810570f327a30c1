//! Guard rails: what cannot be answered halts with a place.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

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
