//! Conduction of heat.
//!
//! Goal: temperatures in slab, cylinder and sphere over time, under held temperatures, fluxes and films; the stable increment at
//! its limit; heat that is neither lost nor made. Source: closed forms (Carslaw and Jaeger 1959, Conduction of Heat in Solids:
//! 3.3 slab, 3.11 film, 2.9 flux into a half-space, 7.6 cylinder, 9.4 hollow sphere), their series summed here. Tolerance: 0.5 %
//! of the range of temperature at the worst node, the order in the mesh asserted first; forward differences of first order in
//! time keep an increment of the second order in the mesh.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common;
use crate::common::Memory;
use crate::common::solid::{grid, run};
use revolve::user::Routines;

/// Diffusivity of the material below.
const ALPHA: f64 = 0.1;

/// A grid of elements with temperatures, and a material that hardly resists: what conducts bounds the increment.
fn conducting(n: usize, m: usize, triangles: bool, place: impl Fn(usize, usize) -> [f64; 2]) -> String {
    grid(n, m, triangles, place).replace("type=CAX4R", "type=CAX4RT").replace("type=CAX3", "type=CAX3T")
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n*Elastic\n 0.01, 0.3\n\
           *Conductivity\n 0.1,\n*Specific Heat\n 0.5,\n"
}

fn step(duration: f64, cards: &str) -> String {
    format!(
        "*Step\n*Dynamic Temperature-displacement, Explicit\n , {duration}\n{cards}*Output, field, number interval=1\n\
         *Node Output\n NT, RFL\n*Element Output\n TEMP, HFL\n*Output, history, number interval=10\n*Energy Output\n ALLHF, ALLIHE\n*End Step\n"
    )
}

/// Points and temperatures of the last frame.
fn temperatures(memory: &Memory) -> Vec<([f64; 2], f64)> {
    let frame = memory.frames.last().expect("a frame");
    let field = frame.point_fields.iter().find(|f| f.name == "NT11").expect("NT11");
    frame.points.iter().copied().zip(field.values.iter().copied()).collect()
}

/// Largest departure from an answer, over all nodes.
fn worst(deck: &str, exact: impl Fn([f64; 2]) -> f64) -> f64 {
    let (outcome, memory) = run(deck);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    temperatures(&memory).into_iter().map(|(place, t)| (t - exact(place)).abs()).fold(0.0, f64::max)
}

/// Errors on meshes twice as fine each: of second order, and small at the end.
#[track_caller]
fn converges(name: &str, errors: &[f64], least: f64) {
    let [.., before, last] = errors else { panic!("two meshes") };
    let order = (before / last).log2();
    println!("{name}: errors {errors:?}, order {order:.2}");
    assert!(order > least && order < 2.6, "{name}: order {order}, {errors:?}");
    assert!(*last < 5e-3, "{name}: {errors:?}");
}

/// Slab of thickness 1, insulated at z = 0 and held at 1 from t = 0 on at z = 1, after the time t.
fn slab(z: f64, t: f64) -> f64 {
    let term = |n: usize| {
        let l = (n as f64 + 0.5) * PI;
        let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        2.0 * sign / l * (l * z).cos() * (-l * l * ALPHA * t).exp()
    };
    1.0 - (0..40).map(term).sum::<f64>()
}

#[test]
fn a_slab() {
    let held = step(2.0, "*Boundary\n J1, 11, 11, 1.\n");
    let errors = [8, 16, 32].map(|n| {
        let deck = conducting(2, n, false, |i, j| [1.0 + i as f64 / n as f64, j as f64 / n as f64]) + &held;
        worst(&deck, |[_, z]| slab(z, 2.0))
    });
    converges("slab", &errors, 1.6);
}

/// The same on quadrilaterals without a right angle, which reach the axis; and on triangles.
#[test]
fn a_slab_on_skewed_meshes() {
    let held = step(2.0, "*Boundary\n J1, 11, 11, 1.\n");
    let errors = [8, 16, 32].map(|n| {
        let place = |i: usize, j: usize| {
            let inside = |k: usize| if k == 0 || k == n { 0.0 } else { 0.3 / n as f64 };
            let (r, z) = (i as f64 / n as f64, j as f64 / n as f64);
            let (wave_r, wave_z) = (((3 * i + 5 * j) % 7) as f64 / 3.0 - 1.0, ((5 * i + 2 * j) % 7) as f64 / 3.0 - 1.0);
            [r + inside(i) * wave_r, z + inside(j) * wave_z]
        };
        worst(&(conducting(n, n, false, place) + &held), |[_, z]| slab(z, 2.0))
    });
    converges("slab, skewed", &errors, 1.6);
    let errors = [8, 16, 32].map(|n| {
        let columns = n / 2;
        let top: String = (0..=columns).map(|i| format!(" {},\n", 1 + i + n * (columns + 1))).collect();
        let deck = conducting(columns, n, true, |i, j| [i as f64 / columns as f64, j as f64 / n as f64]);
        worst(&(deck + &format!("*Nset, nset=J1\n{top}") + &held), |[_, z]| slab(z, 2.0))
    });
    converges("slab, triangles", &errors, 1.5);
}

/// A cylinder of radius 1, 1 at the start, whose surface is held at 0.
#[test]
fn a_cylinder_with_its_axis() {
    let zero = |n: usize| {
        let mut x = (n as f64 + 0.75) * PI;
        (0..30).for_each(|_| x += libm::j0(x) / libm::j1(x));
        x
    };
    let exact = |r: f64, t: f64| -> f64 {
        let term = |n| {
            let l = zero(n);
            2.0 / (l * libm::j1(l)) * libm::j0(l * r) * (-l * l * ALPHA * t).exp()
        };
        (0..20).map(term).sum()
    };
    let held =
        "*Initial Conditions, type=TEMPERATURE\n ALL, 1.\n".to_owned() + &step(1.0, "*Boundary\n I1, 11, 11, 0.\n");
    let errors = [8, 16, 32].map(|n| {
        let deck = conducting(n, 2, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64]) + &held;
        worst(&deck, |[r, _]| exact(r, 1.0))
    });
    converges("cylinder", &errors, 1.7);
}

/// A hollow sphere from 1 to 2, at 0; from t = 0 on held at 1 inside and at 0 outside: r T is that of a slab.
#[test]
fn a_hollow_sphere() {
    let exact = |[r, z]: [f64; 2], t: f64| -> f64 {
        let s = r.hypot(z);
        let term = |n: usize| {
            let l = n as f64 * PI;
            2.0 / l * (l * (s - 1.0)).sin() * (-l * l * ALPHA * t).exp()
        };
        ((2.0 - s) - (1..40).map(term).sum::<f64>()) / s
    };
    let held = step(1.0, "*Boundary\n I0, 11, 11, 1.\n I1, 11, 11, 0.\n");
    let errors = [6, 12, 24].map(|n| {
        let place = |i: usize, j: usize| {
            let (s, angle) = (1.0 + i as f64 / n as f64, 0.5 * PI * j as f64 / (2 * n) as f64);
            if j == 2 * n { [0.0, s] } else { [s * angle.cos(), s * angle.sin()] }
        };
        worst(&(conducting(n, 2 * n, false, place) + &held), |place| exact(place, 1.0))
    });
    converges("sphere", &errors, 1.7);
}

/// A slab that starts at 1, insulated at z = 0 and beside a fluid of 0 at z = 1, Biot number 2.
#[test]
fn a_film() {
    let root = |n: usize| {
        let (mut low, mut high) = (n as f64 * PI, (n as f64 + 0.5) * PI - 1e-12);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if middle * middle.tan() < 2.0 { low = middle } else { high = middle }
        }
        low
    };
    let exact = |z: f64, t: f64| -> f64 {
        let term = |n| {
            let l = root(n);
            4.0 * l.sin() / (2.0 * l + (2.0 * l).sin()) * (l * z).cos() * (-l * l * ALPHA * t).exp()
        };
        (0..30).map(term).sum()
    };
    let with = |n: usize, film: &str| {
        conducting(2, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64])
            + "*Initial Conditions, type=TEMPERATURE\n ALL, 1.\n"
            + &step(2.0, film)
    };
    let errors = [8, 16, 32].map(|n| worst(&with(n, "*Film\n EJ1, F3, 0., 0.2\n"), |[_, z]| exact(z, 2.0)));
    converges("film", &errors, 1.7);
    let by = |film: &str| temperatures(&run(&with(8, film)).1);
    assert_eq!(by("*Film\n EJ1, F3, 0., 0.2\n"), by("*Sfilm\n J1, F, 0., 0.2\n"));
    // Amplitudes of the fluid and of the coefficient.
    let twice = "*Amplitude, name=TWICE\n 0., 2.\n*Step";
    let amplified =
        with(8, "*Film, film amplitude=TWICE, amplitude=TWICE\n EJ1, F3, 0.25, 0.1\n").replace("*Step", twice);
    assert_eq!(temperatures(&run(&amplified).1), by("*Film\n EJ1, F3, 0.5, 0.2\n"));
}

/// A constant flux into what is as good as a half-space: q/k (2 sqrt(at/pi) exp(-x^2/4at) - x erfc(x/2 sqrt(at))).
#[test]
fn a_flux_into_a_half_space() {
    let exact = |z: f64, t: f64| {
        let (x, at) = (1.0 - z, ALPHA * t);
        2.0 * (at / PI).sqrt() * (-x * x / (4.0 * at)).exp() - x * libm::erfc(x / (2.0 * at.sqrt()))
    };
    let with = |n: usize, flux: &str| {
        conducting(2, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64]) + &step(0.2, flux)
    };
    let errors = [16, 32, 64].map(|n| worst(&with(n, "*Dflux\n EJ1, S3, 0.1\n"), |[_, z]| exact(z, 0.2)));
    converges("flux", &errors, 1.7);
    let by = |flux: &str| temperatures(&run(&with(16, flux)).1);
    assert_eq!(by("*Dflux\n EJ1, S3, 0.1\n"), by("*Dsflux\n J1, S, 0.1\n"));
}

/// What is heated evenly stays even to rounding, on a skewed mesh that reaches the axis: T = q t/(rho c). So does heat into
/// nodes that is as large.
#[test]
fn even_heat_stays_even() {
    let place = |i: usize, j: usize| {
        let wave = |k: usize| (k % 5) as f64 * 0.05;
        [i as f64 + if i == 0 { 0.0 } else { wave(2 * i + 3 * j) }, j as f64 + wave(3 * i + j)]
    };
    let deck = conducting(4, 4, false, place) + &step(3.0, "*Dflux\n SOLID, BF, 0.7\n");
    let error = worst(&deck, |_| 0.7 * 3.0);
    assert!(error < 1e-12, "{error}");
    let one = conducting(1, 1, false, |i, j| [1.0 + i as f64, j as f64]) + &step(0.5, "*Cflux\n ALL, 11, 0.6\n");
    let (_, memory) = run(&one);
    let energies = memory.rows.last().expect("a row").1.clone();
    assert!(energies.iter().all(|e| (e / 1.2 - 1.0).abs() < 1e-12), "{energies:?}");
}

/// k = 0.1 (1 + T): with the heat function T + T^2/2 the steady slab between 0 and 1 is linear in it, and 0.15 flows through it.
#[test]
fn conductivity_over_temperature() {
    let deck = conducting(1, 16, false, |i, j| [1.0 + i as f64 / 16.0, j as f64 / 16.0])
        .replace("*Conductivity\n 0.1,\n", "*Conductivity\n 0.1, 0.\n 0.2, 1.\n")
        + &step(30.0, "*Boundary\n J0, 11, 11, 0.\n J1, 11, 11, 1.\n");
    let (_, memory) = run(&deck);
    let exact = |z: f64| (1.0 + 3.0 * z).sqrt() - 1.0;
    let worst = temperatures(&memory).into_iter().map(|([_, z], t)| (t - exact(z)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst}");
    let frame = memory.frames.last().expect("a frame");
    let flux = frame.cell_fields.iter().find(|f| f.name == "HFL").expect("HFL");
    assert_eq!(flux.component_names, ["HFL1", "HFL2"]);
    let axial = flux.values.chunks(2).map(|q| (q[1] / -0.15 - 1.0).abs()).fold(0.0, f64::max);
    assert!(axial < 2e-3, "{axial}");
    // What is held at the top gives the flux times the area of the ring.
    let reaction = frame.point_fields.iter().find(|f| f.name == "RFL11").expect("RFL11");
    let top: f64 = frame.points.iter().zip(&reaction.values).filter(|(p, _)| p[1] == 1.0).map(|(_, q)| q).sum();
    let area = PI * ((17.0_f64 / 16.0).powi(2) - 1.0);
    assert!((top / (0.15 * area) - 1.0).abs() < 2e-3, "{top}");
}

/// c = 0.5 (1 + T): of the heat q t a volume T + T^2/2 = q t/0.5 rho.
#[test]
fn specific_heat_over_temperature() {
    let deck = conducting(2, 2, false, |i, j| [i as f64, j as f64])
        .replace("*Specific Heat\n 0.5,\n", "*Specific Heat\n 0.5, 0.\n 1., 1.\n")
        + &step(1.0, "*Dflux\n SOLID, BF, 1.2\n").replace(" , 1\n", " , 1, , 0.01\n");
    let error = worst(&deck, |_| (1.0 + 2.0 * 1.2_f64).sqrt() - 1.0);
    assert!(error < 1e-4, "{error}");
}

/// Heat given from outside is what is taken up, whatever gives it.
#[test]
fn no_heat_is_lost() {
    let place = |i: usize, j: usize| [i as f64 * 0.2, j as f64 * 0.1 + 0.03 * (i % 2) as f64];
    let deck = conducting(5, 10, false, place)
        + "*Amplitude, name=RAMP\n 0., 0., 1., 1.\n"
        + &step(
            2.0,
            "*Boundary, amplitude=RAMP\n J0, 11, 11, 3.\n*Film\n EJ1, F3, 5., 0.1\n*Dflux\n EI1, S2, -0.2\n*Cflux\n 7, 11, 0.01\n",
        );
    let (_, memory) = run(&deck);
    for (_, row) in &memory.rows[1..] {
        assert!(row[0].abs() > 1e-6 && (row[0] / row[1] - 1.0).abs() < 1e-11, "{row:?}");
    }
}

/// Rows of temperatures that alternate: they stay bounded at the increment chosen, and grow 2 % above it.
#[test]
fn the_increment_is_stable_up_to_its_limit() {
    let grown = |factor: f64| {
        let mut deck = conducting(2, 8, false, |i, j| [1e3 + i as f64, j as f64]).replace(" 0.01, 0.3", " 1e-5, 0.3");
        deck += "*Initial Conditions, type=TEMPERATURE\n";
        for node in 0..27 {
            let sign = if (node / 3) % 2 == 0 { 1.0 } else { -1.0 };
            writeln!(deck, " {}, {sign}", node + 1).expect("text");
        }
        let dynamic = format!("*Dynamic Temperature-displacement, Explicit, scale factor={factor}");
        let step = step(1000.0, "").replace("*Dynamic Temperature-displacement, Explicit", &dynamic);
        let (outcome, memory) = run(&(deck + &step));
        assert!(outcome.increments > 150, "{}", outcome.increments);
        temperatures(&memory).into_iter().map(|(_, t)| t.abs()).fold(0.0, f64::max)
    };
    let (at, above) = (grown(1.0), grown(1.02));
    assert!(at <= 1.0 && above > 10.0, "{at} {above}");
}

/// A later step replaces what an earlier one gave, and what was held is free again.
#[test]
fn conditions_over_steps() {
    let mesh = conducting(1, 4, false, |i, j| [1.0 + i as f64, j as f64]);
    let second = step(5.0, "*Boundary, op=NEW\n I0, 1, 1\n*Dflux, op=NEW\n SOLID, BF, 0.3\n");
    let deck = mesh + &step(5.0, "*Boundary\n ALL, 11, 11, 2.\n*Dflux\n SOLID, BF, 0.9\n") + &second;
    let error = worst(&deck, |_| 2.0 + 0.3 * 5.0);
    assert!(error < 1e-12, "{error}");
}

/// Without a step that solves for temperatures the cards are told, and change no bit.
#[test]
fn cards_of_heat_without_temperatures_are_told() {
    let cards = "*Boundary\n J0, 11, 11, 3.\n*Cflux\n 1, 11, 2.\n*Film\n EJ1, F3, 5., 0.1\n";
    let with = |cards: &str| {
        conducting(2, 2, false, |i, j| [i as f64, j as f64])
            + "*Initial Conditions, type=VELOCITY\n ALL, 2, 0.01\n*Step\n*Dynamic, Explicit\n , 50.\n*Boundary\n J0, 2, 2\n"
            + cards
            + "*End Step\n"
    };
    let told = common::prepared(&with(cards), &[], &Routines::none()).plan.ledger.unused;
    for what in ["*CONDUCTIVITY", "*BOUNDARY J0, 11", "*CFLUX", "*FILM"] {
        assert!(told.iter().any(|u| u.what == what), "{what}: {told:?}");
    }
    assert_eq!(run(&with(cards)).0.digest, run(&with("")).0.digest);
    let plain = with("").replace("CAX4RT", "CAX4R").replace("*Conductivity\n 0.1,\n", "");
    assert_eq!(run(&plain).0.digest, run(&with("")).0.digest);
}

#[test]
fn what_has_no_temperature_is_refused() {
    let codes = |text: &str| -> Vec<&'static str> {
        let found = revolve::job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics;
        found.iter().filter(|d| d.severity == revolve::deck::Severity::Error).map(|d| d.code).collect()
    };
    let deck = conducting(2, 2, false, |i, j| [i as f64, j as f64]) + &step(1.0, "*Dflux\n SOLID, BF, 1.\n");
    assert!(codes(&deck).is_empty());
    for (from, to, code) in [
        ("CAX4RT", "CAX4R", "P065"),
        ("*Conductivity\n 0.1,\n", "", "P066"),
        ("*Specific Heat\n 0.5,\n", "", "P066"),
        ("SOLID, BF, 1.", "SOLID, BX, 1.", "M132"),
    ] {
        assert_eq!(codes(&deck.replace(from, to)), [code], "{from}");
    }
}

/// Threads share elements that are many: the same bits on 1, 2 and 5.
#[test]
fn the_number_of_threads_changes_no_bit() {
    let deck = conducting(50, 50, false, |i, j| [i as f64, j as f64 + 0.1 * (i % 3) as f64])
        + &step(60.0, "*Boundary\n J1, 11, 11, 1.\n*Film\n EI1, F2, 2., 0.1\n");
    let digest = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&deck).0.digest)
    };
    let one = digest(1);
    assert!([2, 5].iter().all(|&threads| digest(threads) == one));
}
