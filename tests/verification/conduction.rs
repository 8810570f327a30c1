//! Heat conduction.
//!
//! Goal: transient temperatures in slab, cylinder and sphere with prescribed temperatures, fluxes and films; stability
//! at the largest stable increment; conservation of heat.
//! Source: closed forms (Carslaw and Jaeger 1959, Conduction of Heat in Solids: 3.3 slab, 3.11 film, 2.9 flux into a
//! half-space, 7.6 cylinder, 9.4 hollow sphere) with their series summed here.
//! Tolerance: 0.5 % of the temperature range at the worst node, after the order in the mesh is asserted. Forward
//! differences are of first order in time, and the increment is proportional to the square of the element size.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common;
use crate::common::RecordedOutput;
use crate::common::solid::{grid, run};
use revolve::user::Routines;

/// Thermal diffusivity of the material below.
const ALPHA: f64 = 0.1;

/// Returns a grid of thermally coupled elements of a very soft material, so that conduction limits the increment.
fn conducting_grid(n: usize, m: usize, triangles: bool, place: impl Fn(usize, usize) -> [f64; 2]) -> String {
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

/// Returns the nodes and temperatures of the last frame.
fn temperatures(memory: &RecordedOutput) -> Vec<([f64; 2], f64)> {
    let frame = memory.frames.last().expect("a frame");
    let field = frame.point_fields.iter().find(|f| f.name == "NT11").expect("NT11");
    frame.points.iter().copied().zip(field.values.iter().copied()).collect()
}

/// Returns the largest nodal error of the final temperature.
fn largest_error(deck: &str, exact: impl Fn([f64; 2]) -> f64) -> f64 {
    let (outcome, memory) = run(deck);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    temperatures(&memory).into_iter().map(|(place, t)| (t - exact(place)).abs()).fold(0.0, f64::max)
}

/// Asserts that errors on successively refined meshes decrease with second order and end below 0.5 %.
#[track_caller]
fn assert_convergence(name: &str, errors: &[f64], least: f64) {
    let [.., before, last] = errors else { panic!("two meshes") };
    let order = (before / last).log2();
    println!("{name}: errors {errors:?}, order {order:.2}");
    assert!(order > least && order < 2.6, "{name}: order {order}, {errors:?}");
    assert!(*last < 5e-3, "{name}: {errors:?}");
}

/// Slab of thickness 1, insulated at z = 0, with T = 1 at z = 1 from t = 0 on.
fn slab_temperature(z: f64, t: f64) -> f64 {
    let term = |n: usize| {
        let l = (n as f64 + 0.5) * PI;
        let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        2.0 * sign / l * (l * z).cos() * (-l * l * ALPHA * t).exp()
    };
    1.0 - (0..40).map(term).sum::<f64>()
}

#[test]
fn slab_temperature_matches_series() {
    let held = step(2.0, "*Boundary\n J1, 11, 11, 1.\n");
    let errors = [8, 16, 32].map(|n| {
        let deck = conducting_grid(2, n, false, |i, j| [1.0 + i as f64 / n as f64, j as f64 / n as f64]) + &held;
        largest_error(&deck, |[_, z]| slab_temperature(z, 2.0))
    });
    assert_convergence("slab", &errors, 1.6);
}

/// The same slab on skewed quadrilaterals that reach the axis, and on triangles.
#[test]
fn slab_temperature_converges_on_skewed_meshes() {
    let held = step(2.0, "*Boundary\n J1, 11, 11, 1.\n");
    let errors = [8, 16, 32].map(|n| {
        let place = |i: usize, j: usize| {
            let inside = |k: usize| if k == 0 || k == n { 0.0 } else { 0.3 / n as f64 };
            let (r, z) = (i as f64 / n as f64, j as f64 / n as f64);
            let (wave_r, wave_z) = (((3 * i + 5 * j) % 7) as f64 / 3.0 - 1.0, ((5 * i + 2 * j) % 7) as f64 / 3.0 - 1.0);
            [r + inside(i) * wave_r, z + inside(j) * wave_z]
        };
        largest_error(&(conducting_grid(n, n, false, place) + &held), |[_, z]| slab_temperature(z, 2.0))
    });
    assert_convergence("slab, skewed", &errors, 1.6);
    let errors = [8, 16, 32].map(|n| {
        let columns = n / 2;
        let top: String = (0..=columns).map(|i| format!(" {},\n", 1 + i + n * (columns + 1))).collect();
        let deck = conducting_grid(columns, n, true, |i, j| [i as f64 / columns as f64, j as f64 / n as f64]);
        largest_error(&(deck + &format!("*Nset, nset=J1\n{top}") + &held), |[_, z]| slab_temperature(z, 2.0))
    });
    assert_convergence("slab, triangles", &errors, 1.5);
}

/// Cylinder of radius 1 with initial temperature 1 and surface temperature 0.
#[test]
fn cylinder_temperature_matches_series() {
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
        let deck = conducting_grid(n, 2, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64]) + &held;
        largest_error(&deck, |[r, _]| exact(r, 1.0))
    });
    assert_convergence("cylinder", &errors, 1.7);
}

/// Hollow sphere from radius 1 to 2 with initial temperature 0, inner temperature 1 and outer temperature 0. The
/// product r T satisfies the equation of a slab.
#[test]
fn hollow_sphere_temperature_matches_series() {
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
        largest_error(&(conducting_grid(n, 2 * n, false, place) + &held), |place| exact(place, 1.0))
    });
    assert_convergence("sphere", &errors, 1.7);
}

/// Slab with initial temperature 1, insulated at z = 0, with a film to a fluid of temperature 0 at z = 1.
/// Biot number 2.
#[test]
fn slab_with_film_matches_series() {
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
        conducting_grid(2, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64])
            + "*Initial Conditions, type=TEMPERATURE\n ALL, 1.\n"
            + &step(2.0, film)
    };
    let errors = [8, 16, 32].map(|n| largest_error(&with(n, "*Film\n EJ1, F3, 0., 0.2\n"), |[_, z]| exact(z, 2.0)));
    assert_convergence("film", &errors, 1.7);
    let by = |film: &str| temperatures(&run(&with(8, film)).1);
    assert_eq!(by("*Film\n EJ1, F3, 0., 0.2\n"), by("*Sfilm\n J1, F, 0., 0.2\n"));
    // Amplitudes of the sink temperature and of the film coefficient.
    let twice = "*Amplitude, name=TWICE\n 0., 2.\n*Step";
    let amplified =
        with(8, "*Film, film amplitude=TWICE, amplitude=TWICE\n EJ1, F3, 0.25, 0.1\n").replace("*Step", twice);
    assert_eq!(temperatures(&run(&amplified).1), by("*Film\n EJ1, F3, 0.5, 0.2\n"));
}

/// Constant flux into a practically semi-infinite body: T = q/k (2 sqrt(at/pi) exp(-x^2/4at) - x erfc(x/2 sqrt(at))).
#[test]
fn half_space_with_flux_matches_closed_form() {
    let exact = |z: f64, t: f64| {
        let (x, at) = (1.0 - z, ALPHA * t);
        2.0 * (at / PI).sqrt() * (-x * x / (4.0 * at)).exp() - x * libm::erfc(x / (2.0 * at.sqrt()))
    };
    let with = |n: usize, flux: &str| {
        conducting_grid(2, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64]) + &step(0.2, flux)
    };
    let errors = [16, 32, 64].map(|n| largest_error(&with(n, "*Dflux\n EJ1, S3, 0.1\n"), |[_, z]| exact(z, 0.2)));
    assert_convergence("flux", &errors, 1.7);
    let by = |flux: &str| temperatures(&run(&with(16, flux)).1);
    assert_eq!(by("*Dflux\n EJ1, S3, 0.1\n"), by("*Dsflux\n J1, S, 0.1\n"));
}

/// Uniform heating of a skewed mesh that reaches the axis stays uniform to rounding: T = q t/(rho c). The same holds
/// for concentrated fluxes.
#[test]
fn uniform_heating_stays_uniform() {
    let place = |i: usize, j: usize| {
        let wave = |k: usize| (k % 5) as f64 * 0.05;
        [i as f64 + if i == 0 { 0.0 } else { wave(2 * i + 3 * j) }, j as f64 + wave(3 * i + j)]
    };
    let deck = conducting_grid(4, 4, false, place) + &step(3.0, "*Dflux\n SOLID, BF, 0.7\n");
    let error = largest_error(&deck, |_| 0.7 * 3.0);
    assert!(error < 1e-12, "{error}");
    let one = conducting_grid(1, 1, false, |i, j| [1.0 + i as f64, j as f64]) + &step(0.5, "*Cflux\n ALL, 11, 0.6\n");
    let (_, memory) = run(&one);
    let energies = memory.rows.last().expect("a row").1.clone();
    assert!(energies.iter().all(|e| (e / 1.2 - 1.0).abs() < 1e-12), "{energies:?}");
}

/// k = 0.1 (1 + T): the steady slab between 0 and 1 is linear in T + T^2/2, with a flux of 0.15.
#[test]
fn temperature_dependent_conductivity_matches_closed_form() {
    let deck = conducting_grid(1, 16, false, |i, j| [1.0 + i as f64 / 16.0, j as f64 / 16.0])
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
    // The reaction flux at the fixed end is the flux times the area of the ring.
    let reaction = frame.point_fields.iter().find(|f| f.name == "RFL11").expect("RFL11");
    let top: f64 = frame.points.iter().zip(&reaction.values).filter(|(p, _)| p[1] == 1.0).map(|(_, q)| q).sum();
    let area = PI * ((17.0_f64 / 16.0).powi(2) - 1.0);
    assert!((top / (0.15 * area) - 1.0).abs() < 2e-3, "{top}");
}

/// c = 0.5 (1 + T): T + T^2/2 = q t/(0.5 rho).
#[test]
fn temperature_dependent_specific_heat_matches_closed_form() {
    let deck = conducting_grid(2, 2, false, |i, j| [i as f64, j as f64])
        .replace("*Specific Heat\n 0.5,\n", "*Specific Heat\n 0.5, 0.\n 1., 1.\n")
        + &step(1.0, "*Dflux\n SOLID, BF, 1.2\n").replace(" , 1\n", " , 1, , 0.01\n");
    let error = largest_error(&deck, |_| (1.0 + 2.0 * 1.2_f64).sqrt() - 1.0);
    assert!(error < 1e-4, "{error}");
}

/// The heat stored equals the heat supplied, for each kind of source.
#[test]
fn heat_is_conserved() {
    let place = |i: usize, j: usize| [i as f64 * 0.2, j as f64 * 0.1 + 0.03 * (i % 2) as f64];
    let deck = conducting_grid(5, 10, false, place)
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

/// Returns two stacked columns of rings from r = 1 to 2 that meet at z = `meet` and are joined by `cards`. `columns`
/// are the cells along r of the lower and upper body, `rows` the cells per unit length. BASE and HEAD are the end
/// faces, FOOT and TOP the joined surfaces.
fn stacked_columns(columns: [usize; 2], rows: usize, meet: f64, cards: &str) -> String {
    let mut text = String::new();
    let spans = [[0.0, meet], [meet, 1.0]];
    let names = [["LOW", "BASE", "TOP"], ["HIGH", "FOOT", "HEAD"]];
    for (part, (&n, [from, to])) in columns.iter().zip(spans).enumerate() {
        let [body, low, high] = names[part];
        let (m, first) = (((to - from) * rows as f64).round() as usize, 1 + 10_000 * part);
        writeln!(text, "*Node, nset={body}").expect("text");
        for k in 0..(n + 1) * (m + 1) {
            let (i, j) = (k % (n + 1), k / (n + 1));
            let z = from + (to - from) * j as f64 / m as f64;
            writeln!(text, " {}, {:.17e}, {z:.17e}", first + k, 1.0 + i as f64 / n as f64).expect("text");
        }
        writeln!(text, "*Element, type=CAX4RT, elset=SOLID").expect("text");
        for k in 0..n * m {
            let corner = first + k % n + (k / n) * (n + 1);
            let upper = corner + n + 1;
            writeln!(text, " {}, {corner}, {}, {}, {upper}", first + k, corner + 1, upper + 1).expect("text");
        }
        let last_row = first + (m - 1) * n;
        for (name, side, cell, node) in [(low, 1, first, first), (high, 3, last_row, first + m * (n + 1))] {
            writeln!(text, "*Elset, elset=E{name}, generate\n {cell}, {}, 1", cell + n - 1).expect("text");
            writeln!(text, "*Surface, name={name}\n E{name}, S{side}").expect("text");
            writeln!(text, "*Nset, nset=N{name}, generate\n {node}, {}, 1", node + n).expect("text");
        }
    }
    text + "*Nset, nset=ALL\n LOW, HIGH\n*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n\
            *Elastic\n 0.01, 0.3\n*Conductivity\n 0.1,\n*Specific Heat\n 0.5,\n"
        + cards
}

const TIED: &str = "*Tie, name=T\n FOOT, TOP\n";

/// A slab conducts through a tie of nonmatching meshes (3 and 4 cells) like a slab without a tie: the temperature does not
/// vary along the tie. Heat is conserved.
#[test]
fn slab_conducts_through_a_tie_of_nonmatching_meshes() {
    let held = step(2.0, "*Boundary\n NHEAD, 11, 11, 1.\n");
    let found = [1, 2, 4].map(|fine| {
        let (outcome, memory) = run(&(stacked_columns([3 * fine, 4 * fine], 8 * fine, 0.5, TIED) + &held));
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        for (_, row) in &memory.rows[1..] {
            assert!(row[0].abs() > 1e-6 && (row[0] / row[1] - 1.0).abs() < 1e-11, "{row:?}");
        }
        let errors = temperatures(&memory).into_iter().map(|([_, z], t)| (z, t - slab_temperature(z, 2.0)));
        let tied: Vec<f64> = errors.clone().filter(|e| (e.0 - 0.5).abs() < 1e-9).map(|e| e.1).collect();
        let worst = errors.map(|e| e.1.abs()).fold(0.0, f64::max);
        assert!(tied.iter().all(|error| (error - tied[0]).abs() < 1e-9), "{tied:?}");
        [worst, tied[0].abs()]
    });
    // Over both refinements (1.98). The single orders are 2.8 and 1.1, because the rounding of increments to the step time
    // contributes.
    let order = (found[0][1] / found[2][1]).log2() / 2.0;
    println!("slab through a tie, at it: {:?}, order {order:.2}", found.map(|f| f[1]));
    assert!(order > 1.8 && found[2][1] < 6e-4, "{order} {found:?}");
    let worst = found.map(|f| f[0]);
    let order = (worst[1] / worst[2]).log2();
    println!("slab through a tie: errors {worst:?}, order {order:.2}");
    assert!(order > 0.95 && worst[2] < 5e-3, "{order} {worst:?}");
}

/// The temperature also varies along the tie: only the outer half of the lower body is heated, and some slaves are on
/// slopes of the temperature. Node to surface, slaves have the interpolated temperature of the master to rounding; surface to
/// surface, the mean temperatures of both surfaces are equal. The stored heat equals the supplied heat, with constant and
/// with temperature-dependent specific heat.
#[test]
fn tied_temperatures_agree_under_nonuniform_heating() {
    for (varies, by_nodes) in [(false, true), (true, true), (false, false), (true, false)] {
        let tie = if by_nodes { "*Tie, name=T, type=NODE TO SURFACE\n FOOT, TOP\n" } else { TIED };
        let mut deck =
            stacked_columns([3, 4], 8, 0.5, tie) + &step(1.0, "*Cflux\n 4, 11, 0.3\n*Dflux\n SOLID, BF, 0.1\n");
        if varies {
            deck = deck.replace("*Specific Heat\n 0.5,\n", "*Specific Heat\n 0.5, 0.\n 1., 1.\n");
        }
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        let found = temperatures(&memory);
        let at_tie: Vec<([f64; 2], f64)> = found.iter().filter(|p| (p.0[1] - 0.5).abs() < 1e-9).copied().collect();
        let (master, slave) = at_tie.split_at(4);
        assert_eq!(slave.len(), 5);
        assert!(master[3].1 - master[0].1 > 0.01, "{master:?}");
        let worst = slave.iter().map(|&([r, _], t)| {
            let at = 3.0 * (r - 1.0);
            let i = (at.floor() as usize).min(2);
            let share = at - i as f64;
            (t - (1.0 - share) * master[i].1 - share * master[i + 1].1).abs()
        });
        let worst = if by_nodes {
            worst.fold(0.0, f64::max)
        } else {
            // Integral of the temperature over the area, exact for linear facets.
            let heat = |nodes: &[([f64; 2], f64)]| -> f64 {
                let facets = nodes.windows(2).map(|ends| {
                    let ([a, b], [t, u]) = ([ends[0].0[0], ends[1].0[0]], [ends[0].1, ends[1].1]);
                    (b - a) * (t * (2.0 * a + b) + u * (a + 2.0 * b)) / 6.0
                });
                facets.sum()
            };
            (heat(slave) - heat(master)).abs()
        };
        // The curvature of the specific heat over an increment is corrected in the next increment.
        assert!(worst < if varies { 1e-9 } else { 1e-12 }, "{worst:e}");
        for (_, row) in &memory.rows[1..] {
            assert!((row[0] / row[1] - 1.0).abs() < 1e-11, "{row:?}");
        }
    }
}

/// `*EQUATION` on degree of freedom 11: matching meshes give the results of one slab to rounding, and two lumps that
/// share a unit of heat satisfy T1 = 2 T2.
#[test]
fn temperature_equations_match_closed_forms() {
    let held = |set: &str| step(2.0, &format!("*Boundary\n {set}, 11, 11, 1.\n"));
    let whole = conducting_grid(2, 16, false, |i, j| [1.0 + 0.5 * i as f64, j as f64 / 16.0]) + &held("J1");
    let whole = temperatures(&run(&whole).1);
    let joined = stacked_columns([2, 2], 16, 0.5, "*Equation\n 2\n NFOOT, 11, 1., NTOP, 11, -1.\n") + &held("NHEAD");
    let found = temperatures(&run(&joined).1);
    assert_eq!(found.len(), whole.len() + 3);
    for ([r, z], t) in found {
        let one = whole.iter().find(|w| (w.0[0] - r).abs() + (w.0[1] - z).abs() < 1e-9).expect("a node").1;
        assert!((t - one).abs() < 1e-12, "{t} {one}");
    }
    // Two separate elements, each at one temperature, with equal capacity C = rho c V. The sum C T1 + C T2 is not
    // conserved, but T1 = 2 T2 and the heat of the multiplier, C (T1 - 1) = -l and C (T2 - 0) = 2 l, give T2 = 2/5.
    let all = "*Equation\n 2\n LOW, 11, 1., HIGH, 11, -2.\n*Initial Conditions, type=TEMPERATURE\n LOW, 1.\n";
    let (_, memory) = run(&(stacked_columns([1, 1], 2, 0.5, all) + &step(1.0, "")));
    for ([_, z], t) in temperatures(&memory) {
        assert!((t - if z < 0.5 { 0.8 } else { 0.4 }).abs() < 1e-12 || z == 0.5, "{z}: {t}");
    }
    let row = memory.rows.last().expect("a row").1.clone();
    let volume = 0.5 * PI * 3.0;
    assert!(
        (row[1] / (2.0 * 0.5 * volume * 0.2) - 1.0).abs() < 1e-12 && (row[0] / row[1] - 1.0).abs() < 1e-12,
        "{row:?}"
    );
}

#[test]
fn invalid_temperature_equations_are_errors() {
    let codes = |cards: &str, step: &str| -> Vec<&'static str> {
        let text = stacked_columns([2, 2], 4, 0.5, cards) + step;
        let found = revolve::job::prepare_text("case.inp", &text, &[], &Routines::none()).diagnostics;
        found.iter().filter(|d| d.severity == revolve::deck::Severity::Error).map(|d| d.code).collect()
    };
    let plain = step(1.0, "*Dflux\n SOLID, BF, 1.\n");
    let same = " NFOOT, 11, 1., NTOP, 11, -1.\n";
    assert!(codes(&format!("*Equation\n 2\n{same}"), &plain).is_empty());
    for (cards, code) in [
        (format!("*Equation\n 2\n{same} 2\n{same}"), "P018"),
        ("*Equation\n 2\n NFOOT, 11, 1., NTOP, 2, -1.\n".into(), "M103"),
        ("*Node\n 77, 3., 3.\n*Equation\n 2\n NFOOT, 11, 1., 77, 11, -1.\n".into(), "P063"),
        ("*Equation\n 2\n NFOOT, 12, 1., NTOP, 12, -1.\n".into(), "M103"),
    ] {
        assert_eq!(codes(&cards, &plain), [code], "{cards}");
    }
    // In a step that does not solve for temperatures the equation is listed as unused.
    let unused = step(1.0, "").replace("*Dynamic Temperature-displacement, Explicit", "*Dynamic, Explicit");
    let text = stacked_columns([2, 2], 4, 0.5, &format!("*Equation\n 2\n{same}"))
        + &unused.replace(" NT, RFL", " U").replace("TEMP, HFL", "S").replace("ALLHF, ALLIHE", "ALLKE");
    let unused = common::prepared(&text, &[], &Routines::none()).plan.ledger.unused;
    assert!(unused.iter().any(|u| u.what == "*EQUATION between temperatures"), "{unused:?}");
}

/// Temperatures that alternate from row to row remain bounded at the stable increment, and grow at 2 % above it.
#[test]
fn conduction_is_stable_up_to_the_largest_increment() {
    let grown = |factor: f64| {
        let mut deck =
            conducting_grid(2, 8, false, |i, j| [1e3 + i as f64, j as f64]).replace(" 0.01, 0.3", " 1e-5, 0.3");
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

/// Conditions of a later step replace those of the previous step; removed prescribed temperatures are free again.
#[test]
fn thermal_conditions_change_between_steps() {
    let mesh = conducting_grid(1, 4, false, |i, j| [1.0 + i as f64, j as f64]);
    let second = step(5.0, "*Boundary, op=NEW\n I0, 1, 1\n*Dflux, op=NEW\n SOLID, BF, 0.3\n");
    let deck = mesh + &step(5.0, "*Boundary\n ALL, 11, 11, 2.\n*Dflux\n SOLID, BF, 0.9\n") + &second;
    let error = largest_error(&deck, |_| 2.0 + 0.3 * 5.0);
    assert!(error < 1e-12, "{error}");
}

/// In a step that does not solve for temperatures, thermal cards are listed as unused and change no bit.
#[test]
fn thermal_cards_without_a_thermal_step_are_reported() {
    let cards = "*Boundary\n J0, 11, 11, 3.\n*Cflux\n 1, 11, 2.\n*Film\n EJ1, F3, 5., 0.1\n";
    let with = |cards: &str| {
        conducting_grid(2, 2, false, |i, j| [i as f64, j as f64])
            + "*Initial Conditions, type=VELOCITY\n ALL, 2, 0.01\n*Step\n*Dynamic, Explicit\n , 50.\n*Boundary\n J0, 2, 2\n"
            + cards
            + "*End Step\n"
    };
    let unused = common::prepared(&with(cards), &[], &Routines::none()).plan.ledger.unused;
    for what in ["*CONDUCTIVITY", "*BOUNDARY J0, 11", "*CFLUX", "*FILM"] {
        assert!(unused.iter().any(|u| u.what == what), "{what}: {unused:?}");
    }
    assert_eq!(run(&with(cards)).0.digest, run(&with("")).0.digest);
    let plain = with("").replace("CAX4RT", "CAX4R").replace("*Conductivity\n 0.1,\n", "");
    assert_eq!(run(&plain).0.digest, run(&with("")).0.digest);
}

#[test]
fn heat_on_elements_without_temperatures_is_an_error() {
    let codes = |text: &str| -> Vec<&'static str> {
        let found = revolve::job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics;
        found.iter().filter(|d| d.severity == revolve::deck::Severity::Error).map(|d| d.code).collect()
    };
    let deck = conducting_grid(2, 2, false, |i, j| [i as f64, j as f64]) + &step(1.0, "*Dflux\n SOLID, BF, 1.\n");
    assert!(codes(&deck).is_empty());
    for (from, to, code) in [
        ("CAX4RT", "CAX4R", "P065"),
        ("*Conductivity\n 0.1,\n", "", "P066"),
        ("*Specific Heat\n 0.5,\n", "", "P066"),
        // A section without its user subroutine is not planned; nothing is said about its elements.
        ("*Elastic\n 0.01, 0.3\n", "*User Material, constants=1\n 1.,\n", "P004"),
        ("SOLID, BF, 1.", "SOLID, BX, 1.", "M132"),
    ] {
        assert_eq!(codes(&deck.replace(from, to)), [code], "{from}");
    }
}

/// Enough elements for several threads: the same bits on 1, 2 and 5 threads.
#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let deck = conducting_grid(50, 50, false, |i, j| [i as f64, j as f64 + 0.1 * (i % 3) as f64])
        + &step(60.0, "*Boundary\n J1, 11, 11, 1.\n*Film\n EI1, F2, 2., 0.1\n");
    let digest = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&deck).0.digest)
    };
    let one = digest(1);
    assert!([2, 5].iter().all(|&threads| digest(threads) == one));
}

/// The motion has 50 000 increments in the stable increment of conduction, so that heat flows are held over 24 increments.
#[test]
fn held_conduction_changes_temperatures_by_less_than_a_thousandth_and_conserves_heat() {
    let place = |i: usize, j: usize| [10.0 + 0.1 * i as f64, 0.1 * j as f64];
    let slab = conducting_grid(1, 10, false, place).replace("0.01, 0.3", "2e10, 0.3");
    let deck = slab + &step(0.02, "*Boundary\n J1, 11, 11, 1.\n");
    let run_of = |deck: &str| {
        let (outcome, memory) = run(deck);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        for (time, row) in &memory.rows {
            let [supplied, stored] = [row[0], row[1]];
            assert!((supplied - stored).abs() <= 1e-11 * supplied.abs(), "{time}: {supplied} {stored}");
        }
        temperatures(&memory)
    };
    let (held, current) = (run_of(&deck), run_of(&deck.replace("Explicit\n", "Explicit, conduction=CURRENT\n")));
    let changes = held.iter().zip(&current).map(|(held, current)| (held.1 - current.1).abs());
    let largest = changes.fold(0.0, f64::max);
    println!("held conduction: temperatures change by {largest:.1e} of the range");
    assert!(largest > 0.0 && largest < 1e-3, "{largest}");
}
