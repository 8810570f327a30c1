//! Hertzian contact: a sphere pressed and thrown on a rigid plane, and thrown on an elastic plate.
//!
//! Goal: pressure, force and duration of contact between curved surfaces with a small contact area.
//! Source: Hertz 1882 (Johnson, Contact Mechanics, 4.2 and 11.4), Huber 1904 for the internal stress. The tolerance and
//! its reason are stated at each test.

use std::f64::consts::PI;

use revolve::job;
use revolve::user::Routines;

use crate::common::bodies::{DeckRun, assembly, cell_field, elastic, part, point_field, rigid_line, run};
use crate::common::{prepared, project};

/// Returns node positions with cells of length `size` up to `even` and cells that grow by the factor `growth` from
/// there to `end`.
fn graded_positions(size: f64, even: f64, growth: f64, end: f64) -> Vec<f64> {
    let (mut places, mut length) = (vec![0.0], size);
    while places[places.len() - 1] < end {
        let at = places[places.len() - 1];
        if at > even {
            length *= growth;
        }
        places.push(at + length);
    }
    // Scale the graded part to end exactly at `end`.
    let (last, from) = (places[places.len() - 1], even + size);
    let scale = (end - from) / (last - from);
    places.iter().map(|&p| if p <= from { p } else { from + (p - from) * scale }).collect()
}

/// A finished run of a pressed cap.
struct PressedCap {
    ran: DeckRun,
    /// Number of elements along the surface.
    elements: usize,
    /// Contact radius of Hertz.
    radius: f64,
    /// Pressure of Hertz on the axis.
    largest: f64,
}

/// Presses a cap of a sphere of radius 1 (E = rho = 1, nu = 0.3) on a rigid plane, with `cells` elements over the
/// contact radius and a cap of `wide` contact radii.
fn pressed_cap(force: f64, cells: f64, wide: f64) -> PressedCap {
    let modulus = 1.0 / (1.0 - 0.09);
    let a = (0.75 * force / modulus).cbrt();
    let size = wide * a;
    let along = graded_positions(a / cells, 1.5 * a, 1.2, size);
    let n = along.len() - 1;
    let place = |i: usize, j: usize| {
        let r = along[i];
        let foot = 1.0 - (1.0 - r * r).sqrt();
        [r, foot + along[j] * (size - foot) / size]
    };
    // Frequency of the block on its contact stiffness.
    let rate = (2.0 * modulus * a / (PI * size.powi(3))).sqrt();
    let time = 18.0 / rate;
    let deck = part("CAP", [n, n], place, "")
        + &rigid_line("PLANE", &[[0.0, 0.0], [2.0 * size, 0.0]], "")
        + &assembly(&["CAP", "PLANE"], "*Rigid Body, ref node=PLANE.REF, elset=PLANE.E\n")
        + &elastic("CAP", [1.0, 0.3, 1.0], &format!("*Damping, alpha={}\n", 2.0 * rate))
        + &format!(
            "*Surface Interaction, name=HARD\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., {}, 1.\n",
            0.4 * time
        )
        + &format!("*Step\n*Dynamic, Explicit\n , {time}\n*Boundary\n PLANE.REF, 2, 2\n")
        + &format!("*Dsload, amplitude=RAMP\n CAP.J1, P, {:e}\n", force / (PI * size * size))
        + "*Contact Pair, interaction=HARD\n CAP.J0, PLANE.SKIN\n*Output, field, number interval=1\n\
           *Node Output\n U\n*Element Output\n S\n\
           *Output, history, number interval=200\n*Contact Output\n CFN, CAREA\n*End Step\n";
    PressedCap { ran: run(&deck).whole(), elements: n, radius: a, largest: 1.5 * force / (PI * a * a) }
}

/// Returns the error of the pressure of a pressed cap against Hertz, from the stress of the elements under the surface:
/// mean and largest.
fn pressure_error(force: f64, cells: usize) -> [f64; 2] {
    let PressedCap { ran, elements: n, radius: a, largest: middle } = pressed_cap(force, cells as f64, 8.0);
    let (mesh, stress, moved) = (&ran.prepared.plan.mesh, cell_field(ran.end(), "S"), point_field(ran.end(), "U"));
    let mut ratios = Vec::new();
    for (e, element) in mesh.elements.iter().enumerate().take(n) {
        let mean = |i: usize| element.nodes.iter().map(|&n| mesh.points[n][i] + moved[2 * n + i]).sum::<f64>() / 4.0;
        let (r, z) = (mean(0), mean(1));
        if r < 0.8 * a {
            let sum = r * r + z * z - a * a;
            let u = 0.5 * (sum + (sum * sum + 4.0 * a * a * z * z).sqrt());
            let hertz = -middle * (z / u.sqrt()).powi(3) * a * a * u / (u * u + a * a * z * z);
            ratios.push(stress[4 * e + 1] / hertz - 1.0);
        }
    }
    // At the edge of the contact the pressure has a vertical tangent, so the adjacent elements are left out.
    let inner = &ratios[..ratios.len() - cells / 6];
    let mean = inner.iter().sum::<f64>() / inner.len() as f64;
    [mean, inner.iter().fold(0.0_f64, |most, x| most.max(x.abs()))]
}

/// Returns the errors for 1 and 10 kN on a sphere of 50 mm and 200 GPa: contact radii 0.554644 and 1.194944 mm, central
/// pressures 1552.076 and 3343.846 MPa.
fn pressure_errors(levels: &[usize]) -> Vec<[f64; 2]> {
    let mut all = Vec::new();
    for force in [2e-6, 2e-5] {
        for &cells in levels {
            let [mean, worst] = pressure_error(force, cells);
            println!("sphere on a plane, {force:e}, {cells} elements: pressure {mean:+.4}, worst place {worst:.4}");
            all.push([mean, worst]);
        }
    }
    all
}

/// Error below 1 % from six elements over the contact radius on.
#[test]
fn pressed_sphere_pressure_matches_hertz() {
    let levels = pressure_errors(&[6, 12]);
    assert!(levels.iter().all(|l| l[0].abs() < 1e-2), "{levels:?}");
    assert!(levels[1][1] < 2e-2 && levels[3][1] < 2e-2, "{levels:?}");
}

/// `cargo test --release --test verification contact_hertz -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn pressed_sphere_on_the_finest_mesh_matches_hertz() {
    let levels = pressure_errors(&[24]);
    assert!(levels.iter().all(|l| l[0].abs() < 5e-3 && l[1] < 2e-2), "{levels:?}");
}

/// Root mean square of the error of CAREA against Hertz, over four positions of the contact edge within an element, with
/// 3, 6 and 12 elements over the contact radius. The order is 1, because the solution at the edge has no length but
/// that of the elements; the error of the radius is 5 % of an element. Whole hat functions have 9 and 5 % of the area.
#[test]
fn contact_area_converges_to_hertz() {
    let errors = [3.0, 6.0, 12.0].map(|cells: f64| {
        let squares = [0.125, 0.375, 0.625, 0.875].map(|phase| {
            let PressedCap { ran, .. } = pressed_cap(2e-6, cells + phase, 8.0);
            let last = |name: &str| ran.column(name).last().expect("a row")[1];
            let radius = (0.75 * 0.91 * last("CFN2@CAP.J0_PLANE.SKIN").abs()).cbrt();
            (last("CAREA@CAP.J0_PLANE.SKIN") / (PI * radius * radius) - 1.0).powi(2)
        });
        (squares.iter().sum::<f64>() / 4.0).sqrt()
    });
    let order = (errors[1] / errors[2]).log2();
    println!("contact area of a sphere on a plane: rms errors {errors:.4?}, order {order:.2}");
    assert!(order > 0.95, "{errors:?}");
    assert!(errors[0] < 3e-2 && errors[1] < 1.8e-2 && errors[2] < 9e-3, "{errors:?}");
}

/// A block that hits a rigid disc has the area of the disc in contact. The disc ends at the sixth of eight elements.
#[test]
fn contact_area_of_a_partly_covered_surface_is_exact() {
    let deck = part("BLOCK", [8, 4], |i, j| [i as f64 / 8.0, j as f64 / 8.0], "")
        + &rigid_line("DISC", &[[0.0, 0.0], [0.75, 0.0]], "")
        + &assembly(&["BLOCK", "DISC"], "*Rigid Body, ref node=DISC.REF, elset=DISC.E\n")
        + &elastic("BLOCK", [1.0, 0.3, 1.0], "")
        + "*Surface Interaction, name=HARD\n*Initial Conditions, type=VELOCITY\n BLOCK.ALL, 2, -1e-3\n\
           *Step\n*Dynamic, Explicit\n , 0.2\n*Boundary\n DISC.REF, 2, 2\n\
           *Contact Pair, interaction=HARD\n BLOCK.J0, DISC.SKIN\n\
           *Output, history, number interval=10\n*Contact Output\n CAREA\n*End Step\n";
    let ran = run(&deck).whole();
    let areas = ran.column("CAREA@BLOCK.J0_DISC.SKIN");
    let worst = areas[1..].iter().fold(0.0_f64, |worst, row| worst.max((row[1] / (PI * 0.5625) - 1.0).abs()));
    println!("contact area of a partly covered block: {worst:.1e}");
    assert!(areas.len() == 11 && worst < 1e-14, "{areas:?}");
}

/// Throws a sphere of R = 10 mm, E = 70 GPa, nu = 0.3, 2700 kg/m3 against a rigid wall, with `cells` elements over the
/// largest contact radius. The core up to R/5 is left out and its mass is added to the density. Returns largest
/// approach of the centre, largest force and duration over those of Hertz, and the rebound over the impact velocity.
fn thrown_sphere(cells: usize, speed: f64) -> ([f64; 4], DeckRun) {
    let (radius, hole) = (10.0, 2.0_f64);
    // At 10 m/s: 0.11369642 mm, 12434.14 N, 33.46399 microseconds.
    let slower = speed / 1e4;
    let hertz = [0.11369642 * slower.powf(0.8), 12434.14 * slower.powf(1.2), 33.46399e-6 * slower.powf(-0.2)];
    let a = (radius * hertz[0]).sqrt();
    let growth = 1.0 + 0.9 / cells as f64;
    let rays = graded_positions(a / radius / cells as f64, 1.5 * a / radius, growth, PI);
    let deep = graded_positions(a / cells as f64, 1.5 * a, growth, radius - hole);
    let (n, m) = (deep.len() - 1, rays.len() - 1);
    let place = |i: usize, j: usize| {
        let (s, part) = (radius - deep[n - i], deep[n - i] / (radius - hole));
        if j == 0 || j == m {
            return [0.0, if j == 0 { -s } else { s }];
        }
        // The angles between rays become more uniform towards the centre.
        let angle = rays[j] + 0.5 * part * (PI * j as f64 / m as f64 - rays[j]);
        [s * libm::sin(angle), -s * libm::cos(angle)]
    };
    let density = 2.7e-9 / (1.0 - (hole / radius).powi(3));
    let deck = part("BALL", [n, m], place, "")
        + &rigid_line("PLANE", &[[0.0, -radius], [20.0, -radius]], "")
        + &assembly(&["BALL", "PLANE"], "*Rigid Body, ref node=PLANE.REF, elset=PLANE.E\n")
        + &elastic("BALL", [70e3, 0.3, density], "")
        + &format!("*Surface Interaction, name=HARD\n*Initial Conditions, type=VELOCITY\n BALL.ALL, 2, {:e}\n", -speed)
        + &format!("*Step\n*Dynamic, Explicit\n , {:e}\n*Bulk Viscosity\n 0., 0.\n", 1.2 * hertz[2])
        + "*Boundary\n PLANE.REF, 2, 2\n*Contact Pair, interaction=HARD\n BALL.I1, PLANE.SKIN\n\
           *Output, field, number interval=200\n*Node Output\n U\n\
           *Output, history, frequency=1\n*Node Output, nset=PLANE.REF\n RF2\n*End Step\n";
    let ran = run(&deck).whole();
    let (nodes, mass) = (ran.nodes("BALL"), &ran.state.dofs.nodes.mass);
    let all: f64 = nodes.iter().map(|n| mass[n[1]]).sum();
    let centre = |f| nodes.iter().map(|&[n, p]| mass[p] * point_field(f, "U")[2 * n + 1]).sum::<f64>() / all;
    let deepest = ran.memory.frames.iter().fold(0.0_f64, |most, f| most.max(-centre(f)));
    let force = ran.column(&ran.prepared.plan.columns[0].name);
    let most = force.iter().fold(0.0_f64, |most, f| most.max(f[1].abs()));
    let time = force.iter().filter(|f| f[1] != 0.0).map(|f| f[0]).fold(0.0, f64::max);
    let answer = [deepest / hertz[0], most / hertz[1], time / hertz[2], ran.momentum() / (all * speed)];
    println!(
        "sphere thrown at {} m/s, {cells} elements: approach {:.4}, force {:.4}, time {:.4}, rebound {:.4}, lost {:.1e}, drift {:.1e}",
        speed / 1e3,
        answer[0],
        answer[1],
        answer[2],
        answer[3],
        ran.outcome.energy.contact / ran.outcome.energy.initial,
        ran.outcome.energy.drift
    );
    (answer, ran)
}

/// Within 5 % of Hertz and within 1 % of the finer mesh. The rest is the finite size of the sphere (a/R = 0.107).
#[test]
fn sphere_impact_on_a_wall_matches_hertz() {
    let [(coarse, _), (fine, ran)] = [6, 12].map(|cells| thrown_sphere(cells, 1e4));
    let energy = ran.outcome.energy;
    for (c, f) in coarse.iter().zip(fine) {
        assert!((f - 1.0).abs() < 0.05 && (f - c).abs() < 0.01, "{coarse:?} {fine:?}");
    }
    assert!(fine[3] > 0.999 && energy.contact.abs() < 5e-5 * energy.initial && energy.drift < 1e-5, "{energy:?}");
}

/// With decreasing speed the contact area decreases relative to the sphere, and approach, force and duration converge
/// to Hertz.
/// `cargo test --release --test verification contact_hertz -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn sphere_impact_converges_to_hertz_at_low_speed() {
    let errors = [1e4, 1e3, 1e2].map(|speed| thrown_sphere(10, speed).0.map(|x| (x - 1.0).abs()));
    for k in 0..3 {
        assert!(errors[2][k] < errors[1][k] && errors[1][k] < errors[0][k], "{errors:?}");
    }
}

/// `input/sphere_on_plate.inp` with the values in its header, three elements over the contact radius: approach of the
/// centre, force, duration and rebound, within 2 %. Finer meshes converge to -0.9, +0.9 and -1 %, because the plate of
/// 40 contact radii is not a half-space. The rebound loses 1 % to vibrations.
#[test]
fn sphere_impact_on_a_plate_matches_hertz() {
    let text = std::fs::read_to_string(project("input/sphere_on_plate.inp")).expect("a deck");
    let prepared = prepared(&text, &[("k", "3")], &Routines::none());
    let (outcome, history) = job::run_in_memory(&prepared);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    let (force, centre) = (&history.0["CFN2@BALL_PLATE"], &history.0["U2@CENTRE"]);
    let (modulus, mass) = (207e3 / (2.0 * (1.0 - 0.09)), 4.0 / 3.0 * PI * 7.85e-9 * 1e3);
    let approach = (15.0 * mass * 1e6 / (16.0 * modulus * 10f64.sqrt())).powf(0.4);
    let most = 4.0 / 3.0 * modulus * 10f64.sqrt() * approach.powf(1.5);
    let off =
        [-centre.min / approach - 1.0, force.max / most - 1.0, 2.0 * centre.time_min / (2.943 * approach / 1e3) - 1.0];
    let energy = outcome.energy;
    println!(
        "sphere on plate: errors of approach, force and time {off:.4?}, lost {:.1e}, drift {:.1e}",
        energy.contact / energy.initial,
        energy.drift
    );
    assert!(off.iter().all(|x| x.abs() < 0.02), "{off:?}");
    assert!(energy.contact >= 0.0 && energy.contact < 1e-4 * energy.initial && energy.drift < 1e-5, "{energy:?}");
    assert!((history.0["V2@CENTRE"].last / 1e3 - 1.0).abs() < 0.01);
}
