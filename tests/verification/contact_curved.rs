//! Curved interfaces with nonmatching meshes: shells under pressure, press fits.
//!
//! Goal: interface stresses and their order of convergence.
//! Source: Lame's thick vessels (Timoshenko and Goodier 1970, Theory of Elasticity, art. 28 and 136). The tolerance and
//! its reason are stated at each test.

use std::f64::consts::PI;

use crate::common::bodies::{DeckRun, assembly, cell_field, elastic, part, run};

/// Returns the mesh of a quarter spherical shell between two radii; nodes of the last ray have r = 0.
fn shell_part(name: &str, [n, m]: [usize; 2], [inner, outer]: [f64; 2]) -> String {
    let place = |i: usize, j: usize| {
        let radius = inner + (outer - inner) * i as f64 / n as f64;
        let angle = 0.5 * PI * j as f64 / m as f64;
        let [r, z] = [radius * angle.cos(), radius * angle.sin()];
        if j == m { [0.0, radius] } else { [r, z] }
    };
    part(name, [n, m], place, "")
}

/// Returns two spherical shells, 10 to 20 and 20 to 40, with the same number of elements through each wall as around
/// it.
fn two_shells(around: [usize; 2], expansion: &str, step: &str) -> String {
    shell_part("INNER", [around[0]; 2], [10.0, 20.0])
        + &shell_part("OUTER", [around[1]; 2], [20.0, 40.0])
        + &press_fit(expansion, step)
}

/// Returns the cards that fit an inner body into an outer one; E = rho = 1. Gaps between chords, up to a twentieth of
/// an element, are closed.
fn press_fit(expansion: &str, step: &str) -> String {
    let damped = |more: &str| format!("*Damping, alpha=0.07\n{more}");
    let pair = "*Boundary\n INNER.J0, 2, 2\n OUTER.J0, 2, 2\n*Contact Pair, interaction=HARD, adjust=0.5\n INNER.I1, OUTER.I0\n";
    assembly(&["INNER", "OUTER"], "")
        + &elastic("INNER", [1.0, 0.3, 1.0], &damped(expansion))
        + &elastic("OUTER", [1.0, 0.3, 1.0], &damped(""))
        + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 150., 1.\n*Surface Interaction, name=HARD\n"
        + &step.replace("PAIR", pair)
}

/// Returns the errors of the radial stress in the elements next to the interface, divided by a pressure. The errors are
/// the mean over the area, the root mean square, and the largest error. `exact` gives the stress by the initial radius.
/// `columns` are the elements of each body through its wall, `rows` those around it, and `flat` selects a cylinder.
fn interface_errors(
    ran: &DeckRun,
    columns: [usize; 2],
    rows: [usize; 2],
    flat: bool,
    pressure: f64,
    exact: impl Fn(f64) -> f64,
) -> [f64; 3] {
    let (mesh, stress) = (&ran.prepared.plan.mesh, cell_field(ran.end(), "S"));
    let (mut sums, mut area, mut worst) = ([0.0; 2], 0.0, 0.0_f64);
    let inner = (0..rows[0]).map(|j| (j + 1) * columns[0] - 1);
    let outer = (0..rows[1]).map(|j| columns[0] * rows[0] + j * columns[1]);
    for e in inner.chain(outer) {
        let element = &mesh.elements[e];
        let mean = |i: usize| element.nodes.iter().map(|&n| mesh.points[n][i]).sum::<f64>() / 4.0;
        let (r, z) = (mean(0), if flat { 0.0 } else { mean(1) });
        let (radius, [rr, zz, _, rz]) = (r.hypot(z), [0, 1, 2, 3].map(|i| stress[4 * e + i]));
        let radial = (r * r * rr + z * z * zz + 2.0 * r * z * rz) / (radius * radius);
        let error = (radial - exact(radius)) / pressure;
        area += r;
        sums = [sums[0] + r * error, sums[1] + r * error * error];
        worst = worst.max(error.abs());
    }
    [sums[0] / area, (sums[1] / area).sqrt(), worst]
}

/// Prints the errors on successively refined meshes and returns their orders.
fn print_orders<const N: usize>(what: &str, errors: &[[f64; 3]; N]) -> Vec<[f64; 3]> {
    let order = |w: &[[f64; 3]]| [0, 1, 2].map(|i| (w[0][i] / w[1][i]).abs().log2());
    let orders: Vec<_> = errors.windows(2).map(order).collect();
    for e in errors {
        println!("{what}: mean {:+.2e}, rms {:.2e}, worst place {:.2e}", e[0], e[1], e[2]);
    }
    println!("{what}: orders {orders:.2?}");
    orders
}

/// Two shells under external pressure behave as one shell from 10 to 40: sigma = -p c^3 (R^3 - a^3)/(R^3 (c^3 - a^3)).
/// The interface stress is of second order over the area; the largest error is at the axis, where the area vanishes.
#[test]
fn two_spherical_shells_act_as_one_under_pressure() {
    let pressure = 1e-6;
    let step = format!(
        "*Step\n*Dynamic, Explicit\n , 450.\nPAIR*Dsload, amplitude=RAMP\n OUTER.I1, P, {pressure:e}\n*Output, field, number interval=1\n\
         *Element Output\n S\n*End Step\n"
    );
    let exact = |radius: f64| -pressure * 64.0 / 63.0 * (1.0 - 1e3 / radius.powi(3));
    let errors = [[6, 8], [12, 16], [24, 32]].map(|around| {
        let ran = run(&two_shells(around, "", &step)).whole();
        assert!(ran.outcome.energy.drift < 1e-5, "{:?}", ran.outcome.energy);
        interface_errors(&ran, around, around, false, pressure, exact)
    });
    let orders = print_orders("shells under pressure", &errors);
    assert!(orders.iter().all(|o| o[0] > 1.8 && o[1] > 1.8 && o[2] > 1.0), "{orders:?}");
    assert!(errors[2][1] < 5e-4 && errors[2][2] < 2e-3, "{errors:?}");
}

/// Thermal properties, and a heat flux that raises the temperature of the inner body by one degree until t = 150.
const HEAT: &str = "*Conductivity\n 1e-3,\n*Specific Heat\n 1.,\n";
const HEATING: &str = "*Amplitude, name=RATE\n 0., 0., 75., 0.0133333333333333333, 150., 0.\n\
    *Step\n*Dynamic Temperature-displacement, Explicit\n , 450.\nPAIR*Dflux, amplitude=RATE\n INNER.SOLID, BF, 1.\n\
    *Output, field, number interval=1\n*Element Output\n S\n*End Step\n";

/// Returns the deck with thermal expansion of the inner body.
fn with_expansion(deck: &str) -> String {
    deck.replace("CAX4R", "CAX4RT").replace("*Material, name=OUTER\n", &format!("*Material, name=OUTER\n{HEAT}"))
}

/// Thermal growth of the inner shell by 1e-6 presses it into the outer one: p = 148.148148 MPa (4000/27) per 0.02 mm at
/// 200 GPa.
#[test]
fn sphere_press_fit_pressure_matches_lame() {
    let pressure = 4000.0 / 27.0 / 200e3 * 1e-3;
    let exact = |radius: f64| match radius < 20.0 {
        true => -pressure * 8.0 / 7.0 * (1.0 - 1e3 / radius.powi(3)),
        false => -pressure / 7.0 * (64e3 / radius.powi(3) - 1.0),
    };
    let errors = [[6, 8], [12, 16], [24, 32]].map(|around| {
        let deck = two_shells(around, &format!("{HEAT}*Expansion\n 1e-6,\n"), HEATING);
        interface_errors(&run(&with_expansion(&deck)).whole(), around, around, false, pressure, exact)
    });
    let orders = print_orders("press fit of spheres", &errors);
    assert!(orders.iter().all(|o| o[0] > 1.8 && o[1] > 1.8), "{orders:?}");
    assert!(errors[2][0].abs() < 1e-3 && errors[2][1] < 1e-3 && errors[2][2] < 1e-2, "{errors:?}");
}

/// Press fits of a tube and of a solid shaft in plane strain: 65.934066 and 82.417582 MPa per 0.02 mm at 200 GPa. The
/// in-plane strain is 1.3 times the thermal strain because the axial strain is zero.
#[test]
fn cylinder_press_fit_pressures_match_lame() {
    for (inside, per) in [(10.0, 65.934066), (0.0, 82.417582)] {
        let pressure = per / 200e3 * 1e-3;
        let hollow = 1.0 / (1.0 - inside * inside / 400.0);
        let exact = |r: f64| match r < 20.0 {
            true => -pressure * hollow * (1.0 - inside * inside / (r * r)),
            false => -pressure / 3.0 * (1600.0 / (r * r) - 1.0),
        };
        let errors = [1, 2, 4].map(|k| {
            let columns = [6 * k, 8 * k];
            let tube = |name: &str, [n, m]: [usize; 2], [a, b]: [f64; 2]| {
                part(name, [n, m], |i, j| [a + (b - a) * i as f64 / n as f64, 5.0 * j as f64 / m as f64], "")
            };
            let bodies = tube("INNER", [columns[0], 3], [inside, 20.0]) + &tube("OUTER", [columns[1], 4], [20.0, 40.0]);
            let held = "INNER.J1, 2, 2\n OUTER.J1, 2, 2";
            let deck = bodies
                + &press_fit(&format!("{HEAT}*Expansion\n {:e},\n", 1e-6 / 1.3), HEATING)
                    .replace("INNER.J0, 2, 2", &format!("INNER.J0, 2, 2\n {held}"));
            interface_errors(&run(&with_expansion(&deck)).whole(), columns, [3, 4], true, pressure, exact)
        });
        let orders = print_orders(&format!("press fit of a cylinder from {inside}"), &errors);
        assert!(orders.iter().flatten().all(|o| *o > 1.8), "{orders:?}");
        assert!(errors[2].iter().all(|e| e.abs() < 1e-3), "{errors:?}");
    }
}
