//! Implosions and large distortion.

use crate::common::{solid, spheres};
use crate::scene::{GauntletRun, deck, off, text};
use crate::{CaseVerdict, cases};
use revolve::user::Routines;

cases! { "Implosion and large distortion":
    verney_sphere, "imploding shell: hourglass energy, loss of symmetry, flattened elements",
        "stops within 2 % of the inner radii 6, 5, 4, 3 in the limit of 10x10 and 20x20, drift < 0.1 %";
    verney_cylinder, "the same in plane strain",
        "stops within 1 % of the inner radii 6, 5, 4, 3, drift < 0.1 %";
    taylor_at_400, "large expansion of the foot: inverted elements",
        "completed, or halted with element, increment and time; drift < 1 %, all values finite";
    taylor_at_400_controlled, "the same with distortion control: forces that create energy",
        "completed, drift < 1 %, ALLDC not below 0 and < 5 % of the energy";
    a_corner_thrown_through_its_element, "single node with a velocity through its elements; only the stress of the elements stops it",
        "a corner passes the line between its neighbours without distortion control and none does with it; drift < 10 % (only one node has a velocity: the energy of bulk viscosity is counted an increment late)";
    a_foot_that_folds, "soft copper at 400 m/s: the rim of the foot folds over",
        "completed, or halted with element, increment and time; drift < 2 %";
    necking_to_failure, "localisation, deletion of loaded elements",
        "fracture: a whole row of elements deleted; drift < 3 %";
}

fn shell(stop: f64, sphere: bool, n: usize) -> f64 {
    let deck = spheres::verney(stop, sphere, [n, if sphere { n } else { 2 }], spheres::EVEN)
        + "*Output, history, time interval=0.2\n*Node Output, nset=RAY0\n U1\n*End Step\n";
    let scene = text(&deck, &Routines::none());
    assert!(scene.completed(1e-3), "{}", scene.outcome.energy.drift);
    8.0 + scene.column("U1@RAY0").iter().map(|u| u.1).fold(0.0, f64::min)
}

fn verney(sphere: bool, within: f64) -> CaseVerdict {
    // The error is proportional to the square of the element size.
    let found = [6.0, 5.0, 4.0, 3.0].map(|stop| {
        let [coarse, fine] = [10, 20].map(|n| shell(stop, sphere, n));
        (stop, fine + (fine - coarse) / 3.0)
    });
    let holds = found.iter().all(|(stop, r)| off(*r, *stop) < within);
    CaseVerdict { figure: found.map(|(_, r)| format!("{r:.2}")).join(", "), holds }
}

fn verney_sphere() -> CaseVerdict {
    // Value of the reference for a stop at 4 cm.
    assert!(off(spheres::stopping_speed(4.0, true), 0.061_978_707_6) < 1e-6);
    verney(true, 0.02)
}

fn verney_cylinder() -> CaseVerdict {
    verney(false, 0.01)
}

/// Passes if the run is completed with a small energy drift or halts with element, increment and time.
fn located(scene: &GauntletRun, drift: f64) -> CaseVerdict {
    let places = scene.places();
    let finite = places.iter().flatten().all(|x| x.is_finite()) && scene.outcome.energy.total.is_finite();
    let (reason, named) = match &scene.outcome.halt {
        None => ("completed".into(), true),
        Some(halt) => {
            let words = ["element", "increment", "time"];
            (format!("halted ({})", halt.code()), words.iter().all(|w| halt.message().contains(w)))
        }
    };
    let reached = scene.outcome.energy.drift;
    let figure = format!("{reason}, drift {:.1} %", 100.0 * reached);
    CaseVerdict { figure, holds: finite && named && reached < drift }
}

fn taylor_at_400() -> CaseVerdict {
    located(&deck("impact.inp", &[]), 0.01)
}

fn taylor_at_400_controlled() -> CaseVerdict {
    let scene = deck("impact_controlled.inp", &[]);
    let energy = &scene.outcome.energy;
    let share = energy.distortion / energy.initial;
    let figure = format!("drift {:.1} %, ALLDC {:.1} %", 100.0 * energy.drift, 100.0 * share);
    CaseVerdict { figure, holds: scene.completed(0.01) && (0.0..0.05).contains(&share) }
}

fn a_corner_thrown_through_its_element() -> CaseVerdict {
    let deck = |controls: &str| {
        let section = format!(
            "*Section Controls, name=KEEP, {controls}\n*Solid Section, elset=SOLID, material=M, controls=KEEP\n"
        );
        let material = solid::material(1000.0, 0.3, 1.0, "*Plastic\n 1., 0.\n");
        solid::grid(5, 5, false, |i, j| [10.0 + i as f64, j as f64])
            + &material.replace("*Solid Section, elset=SOLID, material=M\n", &section)
            + "*Initial Conditions, type=VELOCITY\n 33, 2, -30.\n*Step\n*Dynamic, Explicit, scale factor=0.5\n , 0.2\n*Boundary\n J0, 2, 2\n\
               *Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n"
    };
    let bare = text(&deck("hourglass=STIFFNESS"), &Routines::none());
    let kept = text(&deck("hourglass=STIFFNESS, distortion control=YES"), &Routines::none());
    // Smallest ratio of a corner's area to that of the undeformed square.
    let least = |scene: &GauntletRun| {
        let group = &scene.prepared.state.elements.groups[0];
        let places = scene.places();
        let corners = |e: usize| group.cells(e).next().expect("a quadrilateral").map(|n| places[n as usize]);
        let area = |at: [[f64; 2]; 4], i: usize| {
            let [a, b, c] = [at[i], at[(i + 1) % 4], at[(i + 3) % 4]];
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        };
        (0..group.len())
            .flat_map(|e| (0..4).map(move |i| (e, i)))
            .map(|(e, i)| area(corners(e), i))
            .fold(f64::MAX, f64::min)
    };
    let (without, with) = (least(&bare), least(&kept));
    let figure = format!(
        "least corner {without:.2} without, {with:.2} with; drift {:.0} %, {:.0} % without",
        100.0 * kept.outcome.energy.drift,
        100.0 * bare.outcome.energy.drift
    );
    CaseVerdict { figure, holds: without < 0.0 && with > 0.0 && kept.completed(0.1) }
}

fn a_foot_that_folds() -> CaseVerdict {
    located(&deck("impact.inp", &[("yield", "5.e7"), ("hardening", "1.e7"), ("time", "40.e-6")]), 0.02)
}

fn necking_to_failure() -> CaseVerdict {
    let scene = deck("necking.inp", &[]);
    let status = scene.field("STATUS");
    let gone = status.iter().filter(|s| **s == 0.0).count();
    let through = status.chunks(8).any(|row| row.iter().all(|s| *s == 0.0));
    let figure = format!("{gone} elements deleted, drift {:.2} %", 100.0 * scene.outcome.energy.drift);
    CaseVerdict { figure, holds: scene.completed(0.03) && through }
}
