//! Units, rounding, many increments, extreme mass ratios.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::scene::{GauntletRun, deck, off, read, text, with};
use crate::{CaseVerdict, cases};

cases! { "Numbers":
    three_systems_of_units, "absolute tolerances in the code",
        "SI, mm-t-s and cm-g-us: equal positions within 1e-9 of the length";
    powers_of_two, "the same, without any difference in rounding",
        "lengths times 8, masses over 4, times times 32: the same bits";
    a_million_increments_of_a_shot, "sums of many small terms",
        "depth of the automatic run (accuracy 1e-8) within 1e-7, drift < 1e-8";
    times_that_round_badly, "t + dt does not reach the end exactly: one increment too many, or an endless step",
        "steps of thirds, sevenths and tenths end exactly, without an additional increment";
    a_clock_that_stands_still, "increment below the rounding error of the time: endless run",
        "halted (R204) with increment and time";
    masses_over_12_decades, "bodies of 1e-6 to 1e6 kg under proportional forces",
        "equal velocities within 1e-12";
}

fn units(m: &str, kg: &str, s: &str) -> GauntletRun {
    let scene = deck("units.inp", &[("m", m), ("kg", kg), ("s", s)]);
    assert!(scene.completed(0.01), "{}", scene.outcome.energy.drift);
    scene
}

fn three_systems_of_units() -> CaseVerdict {
    let places = |m: &str, kg: &str, s: &str| {
        let unit: f64 = m.parse().expect("a number");
        units(m, kg, s).places().iter().flatten().map(|x| x / unit).collect::<Vec<_>>()
    };
    let si = places("1.", "1.", "1.");
    let worst = [places("1.e3", "1.e-3", "1."), places("100.", "1.e3", "1.e6")]
        .iter()
        .fold(0.0_f64, |worst, other| si.iter().zip(other).map(|(a, b)| (a - b).abs() / 16e-3).fold(worst, f64::max));
    println!("units: {worst:.1e}");
    let few = format!("< 1e{:.0}", worst.max(1e-16).log10().ceil());
    CaseVerdict { figure: few, holds: worst < 1e-9 }
}

fn powers_of_two() -> CaseVerdict {
    let (one, other) = (units("1.", "1.", "1."), units("8.", "0.25", "32."));
    let same = |name: &str, unit: f64| one.field(name).iter().zip(other.field(name)).all(|(a, b)| a * unit == b);
    let pascal = 0.25 / 8.0 / 1024.0;
    let holds = same("U", 8.0) && same("V", 0.25) && same("S", pascal) && same("PEEQ", 1.0);
    let counts = [&one, &other].map(|s| s.outcome.increments);
    CaseVerdict {
        figure: if holds { "the same bits".into() } else { "other bits".into() },
        holds: holds && counts[0] == counts[1],
    }
}

fn shot(card: &str) -> GauntletRun {
    text(
        &read("layers.inp").replace("*Dynamic, Explicit\n , 1.e-3\n", card).replace("front = 0.\n", "front = 0.1\n"),
        &Routines::none(),
    )
}

fn long_shot(increment: &str) -> (f64, u64, f64) {
    let depth = |scene: &GauntletRun| scene.outcome.rests.first().expect("it stops").displacement;
    let fixed = shot(&format!("*Dynamic, Explicit, direct user control\n {increment}, 2.5e-4\n"));
    let exact = depth(&shot("*Dynamic, Explicit, accuracy=1.e-8\n , 2.5e-4\n"));
    assert_eq!(fixed.outcome.halt, None);
    (off(depth(&fixed), exact), fixed.outcome.increments, fixed.outcome.energy.drift)
}

fn a_million_increments_of_a_shot() -> CaseVerdict {
    let (error, count, drift) = long_shot("2.5e-10");
    println!("{count} increments: depth {error:.1e}, drift {drift:.1e}");
    let few = |x: f64| format!("1e{:.0}", x.max(1e-16).log10().ceil());
    CaseVerdict {
        figure: format!("depth < {}, drift < {}", few(error), few(drift)),
        holds: count >= 1_000_000 && error < 1e-7 && drift < 1e-8,
    }
}

/// Takes about a minute: `cargo test --release --test gauntlet -- --ignored a_hundred_million`.
#[test]
#[ignore = "runs for a minute"]
fn a_hundred_million_increments_of_a_shot() {
    let (error, count, drift) = long_shot("2.5e-12");
    println!("{count} increments: depth {error:.1e}, drift {drift:.1e}");
    assert!(count >= 100_000_000 && error < 1e-7 && drift < 1e-8);
}

struct ConstantPressure(f64);

impl UserLoad for ConstantPressure {
    fn pressure(&mut self, _: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(self.0);
        Ok(())
    }
}

fn disc(settings: &[(&str, &str)], pressure: f64) -> GauntletRun {
    with("disc.inp", settings, &Routines::none().with_load(ConstantPressure(pressure)))
}

fn times_that_round_badly() -> CaseVerdict {
    let mut holds = true;
    for (dt, time, count) in [
        ("0.03333333333333333", "1.", 30),
        ("0.14285714285714285", "3.", 21),
        ("0.1", "0.3", 3),
        ("0.1", "100.", 1000),
        ("1.e-3", "0.7", 700),
    ] {
        let scene = disc(&[("dt", dt), ("time", time)], 1.0);
        let end: f64 = time.parse().expect("a number");
        let last = scene.memory.rows.last().expect("a row").0;
        println!("{dt} to {time}: {} increments, ends at {last:?}", scene.outcome.increments);
        holds &= scene.completed(1e-9) && last == end && scene.outcome.increments == count;
    }
    CaseVerdict { figure: if holds { "all end exactly".into() } else { "an end is missed".into() }, holds }
}

fn a_clock_that_stands_still() -> CaseVerdict {
    let steps = read("disc.inp");
    let step = &steps[steps.find("*Step").expect("a step")..];
    let late = steps.replace("<dt>, <time>", "1.e8, 1.e9") + &step.replace("<dt>, <time>", "1.e-9, 1.");
    let scene = text(&late, &Routines::none().with_load(ConstantPressure(1e-12)));
    let halt = scene.outcome.halt.as_ref().map(|h| (h.code(), h.message().to_owned()));
    let (code, reason) = halt.unwrap_or(("no halt", String::new()));
    CaseVerdict {
        figure: code.into(),
        holds: code == "R204" && reason.contains("increment") && reason.contains("time"),
    }
}

fn masses_over_12_decades() -> CaseVerdict {
    let speeds: Vec<f64> = (-6..=6)
        .map(|power| {
            let mass = 10f64.powi(power);
            let scene = disc(&[("mass", &format!("{mass:e}"))], mass);
            assert!(scene.completed(1e-9));
            scene.last("V2@REF")
        })
        .collect();
    let worst = speeds.iter().map(|v| off(*v, speeds[6])).fold(0.0, f64::max);
    CaseVerdict { figure: format!("{worst:.0e}"), holds: worst < 1e-12 && speeds[6] != 0.0 }
}
