//! Hourglass patterns.

use crate::common::{solid, spheres};
use crate::scene::{deck, off, text};
use crate::{CaseVerdict, cases};
use revolve::user::Routines;

cases! { "Hourglass":
    point_loads, "forces on single nodes: hourglass modes of one-point elements",
        "ALLAE/ALLIE < 15 % (10x10 elements, singular loads), drift < 1 %";
    coarse_bending, "plate with two elements through the thickness",
        "deflection of the clamped plate (with shear) within 2 % on 20x2 and on 40x4, enhanced control";
    slender_bending, "plate of elements with aspect ratios of three and seven: the hourglass stiffness must not be that of a square element",
        "deflection of the clamped plate (with shear) within 3 % on 12x4 and on 12x8, enhanced control";
    a_plate_that_flows, "plasticity through two and four rows of elements: hourglass control that never yields, or is too soft at hinges",
        "clamped, 15 MPa on Y = 300 MPa: deflection at rest on 20x2 and 40x4 within 4 % of 160x16 (17.38 mm), by default and ENHANCED";
    upsetting, "cylinder compressed between rough plates: hourglass control decides the force",
        "force at 40 % on 8x12: RELAX STIFFNESS, VISCOUS and ENHANCED within 5 % of each other, drift < 0.5 %";
    rubber_blown_up, "rubber sphere, K/mu = 1000, to three times its inner radius: growing sawtooth pattern",
        "without hourglass control, 8x12: every ray within 1 % of the incompressible sphere, ALLKE/ALLIE < 1e-4, drift < 0.1 %";
    a_million_increments_of_free_vibration, "growth of hourglass modes, drift of energy and position over 1e6 increments",
        "energy of the vibration within 1e-6, position of the centre of mass within 1e-9, momentum within 1e-10";
}

fn point_loads() -> CaseVerdict {
    let scene = deck("point_load.inp", &[]);
    let share = scene.last("ALLAE") / scene.last("ALLIE");
    CaseVerdict { figure: format!("ALLAE/ALLIE {:.1} %", 100.0 * share), holds: scene.completed(0.01) && share < 0.15 }
}

/// Timoshenko and Woinowsky-Krieger, sections 16 and 20: w = p a^4/(64 D) (1 + 4 k h^2/a^2...), with the shear
/// deflection p a^2/(4 kappa G h) and kappa = 5/6.
fn coarse_bending() -> CaseVerdict {
    bent([("20", "2"), ("40", "4")], 0.02)
}

fn bent(meshes: [(&str, &str); 2], within: f64) -> CaseVerdict {
    let (p, a, h, e, nu) = (0.1, 100.0_f64, 10.0_f64, 200e3, 0.3);
    let stiffness = e * h.powi(3) / (12.0 * (1.0 - nu * nu));
    let exact = p * a.powi(4) / (64.0 * stiffness) + p * a * a / (4.0 * 5.0 / 6.0 * e / (2.0 * (1.0 + nu)) * h);
    let found = meshes.map(|(nr, nz)| {
        let scene = deck("bending.inp", &[("nr", nr), ("nz", nz)]);
        let values = scene.column("U2@FIRST");
        let tail = &values[values.len() - values.len() / 5..];
        assert!(scene.completed(0.01));
        -tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
    });
    let holds = found.iter().all(|w| off(*w, exact) < within);
    CaseVerdict { figure: format!("{:.3e}, {:.3e} mm; {exact:.3e} by theory", found[0], found[1]), holds }
}

fn slender_bending() -> CaseVerdict {
    bent([("12", "4"), ("12", "8")], 0.03)
}

fn a_plate_that_flows() -> CaseVerdict {
    let plate = |kind: &str, [columns, rows]: [usize; 2]| {
        let place = |i: usize, j: usize| [100.0 * i as f64 / columns as f64, 10.0 * j as f64 / rows as f64];
        let section = format!("material=M, controls=C\n*Section Controls, name=C, hourglass={kind}\n");
        let material = solid::material(200e3, 0.3, 7.85e-9, "*Plastic\n 300., 0.\n").replace("material=M\n", &section);
        let deck = solid::grid(columns, rows, false, place)
            + &material
            + "*Nset, nset=TIP\n 1,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2.e-3, 1.\n*Step\n\
               *Dynamic, Explicit\n , 3.e-3\n*Boundary\n I0, 1, 1\n I1, 1, 2\n*Dsload, amplitude=A\n J1, P, 15.\n\
               *Output, history, number interval=300\n*Node Output, nset=TIP\n U2\n*End Step\n";
        let scene = text(&deck, &Routines::none());
        assert!(scene.completed(2e-3));
        let values = scene.column("U2@TIP");
        -values[values.len() - 100..].iter().map(|v| v.1).sum::<f64>() / 100.0
    };
    let meshes = [[20, 2], [40, 4]];
    let found = ["RELAX STIFFNESS", "ENHANCED"].map(|kind| meshes.map(|mesh| plate(kind, mesh)));
    let holds = found.iter().flatten().all(|w| off(*w, 17.378) < 0.04);
    let [[a, b], [c, d]] = found;
    CaseVerdict { figure: format!("{a:.2}, {b:.2} mm; {c:.2}, {d:.2} mm"), holds }
}

fn upsetting() -> CaseVerdict {
    let force = |kind: &str| {
        let section = format!("material=M, controls=C\n*Section Controls, name=C, hourglass={kind}\n");
        let material = solid::material(200e3, 0.3, 7.85e-9, "*Plastic\n 400., 0.\n 800., 1.\n");
        let deck = solid::grid(8, 12, false, |i, j| [1.25 * i as f64, 1.25 * j as f64])
            + &material.replace("material=M\n", &section)
            + "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2.e-3, 1.\n*Step\n*Dynamic, Explicit\n , 2.e-3\n\
               *Boundary\n I0, 1, 1\n J0, 2, 2\n J1, 1, 1\n*Boundary, amplitude=A\n J1, 2, 2, -6.\n\
               *Output, history, number interval=200\n*Node Output, nset=J1\n RF2\n*Energy Output\n ALLIE, ALLAE\n*End Step\n";
        let scene = text(&deck, &Routines::none());
        assert!(scene.completed(5e-3));
        let names: Vec<String> = scene.prepared.plan.columns.iter().map(|c| c.name.clone()).collect();
        let reactions = names.iter().filter(|n| n.starts_with("RF2")).map(|n| {
            let values = scene.column(n);
            values[values.len() - 10..].iter().map(|v| v.1).sum::<f64>() / 10.0
        });
        1e-3 * reactions.sum::<f64>().abs()
    };
    let found = ["RELAX STIFFNESS", "VISCOUS", "ENHANCED"].map(force);
    let [least, most] = [f64::min, f64::max].map(|f| found.into_iter().reduce(f).expect("forces"));
    let [a, b, c] = found;
    CaseVerdict { figure: format!("{a:.1}, {b:.1}, {c:.1} kN"), holds: most / least < 1.05 }
}

fn rubber_blown_up() -> CaseVerdict {
    let scene = text(&spheres::rubber_sphere(1000.0, [8, 12], ""), &Routines::none());
    let radius = |j: usize| scene.last(&format!("COOR1@RAY{j}")).hypot(scene.last(&format!("COOR2@RAY{j}")));
    let worst = (0..=12).map(|j| off(radius(j), spheres::blown_up())).fold(0.0, f64::max);
    let kinetic = scene.last("ALLKE") / scene.last("ALLIE");
    let holds = scene.completed(1e-3) && worst < 0.01 && kinetic < 1e-4;
    CaseVerdict { figure: format!("within {:.2} %, ALLKE/ALLIE < {:.0e}", 100.0 * worst, kinetic.max(1e-12)), holds }
}

fn a_million_increments_of_free_vibration() -> CaseVerdict {
    let scene = deck("flight.inp", &[]);
    let nodes = &scene.prepared.state.dofs.nodes;
    let mass = &nodes.mass;
    let total: f64 = mass.iter().sum();
    let mean = |name: &str| mass.iter().zip(scene.at_nodes(name)).map(|(m, v)| m * v[1]).sum::<f64>() / total;
    // The top row starts with a velocity higher by a factor of 1.001.
    let top: f64 = (19..=21).map(|label| mass[scene.node(label)]).sum();
    let start = 1e-3 * (1.0 + 1e-3 * top / total);
    let (place, momentum) = (off(mean("U"), start * 250_000.0), off(mean("V"), start));
    // Energy of the vibration: total energy less that of the rigid-body motion.
    let vibration = 0.5 * top * (1.0 - top / total) * 1e-12;
    let drift = scene.outcome.energy.drift * 0.5 * total * start * start / vibration;
    let count = scene.outcome.increments;
    println!("{count} increments, drift {drift:.1e}, place {place:.1e}, momentum {momentum:.1e}");
    let holds = drift < 1e-6 && scene.completed(1e-9) && count == 1_000_000 && place < 1e-9 && momentum < 1e-10;
    let few = |x: f64| format!("1e{:.0}", x.max(1e-16).log10().ceil());
    CaseVerdict {
        figure: format!("energy < {}, place < {}, momentum < {}", few(drift), few(place), few(momentum)),
        holds,
    }
}
