//! Models with known results and levels of refinement, for studies.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::deck::{self, Deck, Diagnostics};
use revolve::job::ParameterOverrides;

use crate::common::ogive;
use crate::common::solid::{WHOLE_VISCOSITY, grid, material};

/// Returns the deck for one level.
pub type DeckFactory = Box<dyn Fn(&ParameterOverrides) -> (Deck, Diagnostics) + Sync>;

/// A model, its refinement, and its independent exact result.
pub struct StudyCase {
    pub name: String,
    /// The deck for one level.
    pub deck: DeckFactory,
    /// The argument of `--refine`.
    pub refine: &'static str,
    pub quantity: String,
    pub exact: f64,
}

/// Returns the levels of a deck text with parameters.
fn with_parameters(text: String) -> DeckFactory {
    Box::new(move |overrides| deck::read_text("case.inp", &text, overrides))
}

/// Returns the levels of a deck text that depends on the number of elements.
fn with_elements(make: impl Fn(usize) -> String + Sync + 'static) -> DeckFactory {
    Box::new(move |overrides| {
        let n = overrides.iter().find(|o| o.0 == "n").and_then(|o| o.1.parse().ok()).expect("n");
        deck::read_text("case.inp", &make(n), &[])
    })
}

const A: f64 = 3.555e-3;
const Y: f64 = 276e6;
const RHO: f64 = 2710.0;
const MASS: f64 = 0.021;

/// Returns `ogive.inp` with other values of its parameters.
fn shot(settings: &[(&str, f64)], dynamic: &str) -> String {
    let mut text = ogive().replace("*Dynamic, Explicit\n , 1.e-3\n", dynamic);
    for (name, value) in settings {
        let line = text.lines().find(|l| l.split('=').next().is_some_and(|n| n.trim() == *name)).expect("defined");
        text = text.replacen(&format!("\n{line}\n"), &format!("\n{name} = {value:e}\n"), 1);
    }
    text
}

/// Increments so small that their error is far below that of the facets.
const FINE: &str = "*Dynamic, Explicit, accuracy=1e-7\n , 1.e-3\n";

fn depth(name: String, text: String, refine: &'static str, exact: f64) -> StudyCase {
    StudyCase { name, deck: with_parameters(text), refine, quantity: "-final(U2@REF)".into(), exact }
}

/// Returns refinements of the facets of the six noses and velocities of `verification/rigid.rs`, with friction and with
/// the three-term law.
pub fn facets() -> Vec<StudyCase> {
    let mut cases = Vec::new();
    // Reference, section 1: closed form if embedded, quadrature of the entry integrals.
    for (v, front, exact) in [
        (569.0, 0.1, 59.612643939e-3),
        (1147.0, 0.1, 221.597433967e-3),
        (569.0, 0.0, 64.8475307e-3),
        (1147.0, 0.0, 226.5690103e-3),
    ] {
        let text = shot(&[("V", v), ("front", front)], FINE);
        cases.push(depth(format!("ogive, {v} m/s, front {front}"), text, "n=10,20,40", exact));
    }
    for (crh, n2) in [(1.0, 7.0 / 24.0), (2.0, 15.0 / 96.0), (6.0, 47.0 / 864.0)] {
        let text = shot(&[("V", 800.0), ("front", 0.1), ("CRH", crh)], FINE);
        cases.push(depth(format!("nose of CRH {crh}"), text, "n=10,20,40", closed_form(800.0, [1.0, 0.0, n2], 0.0)));
    }
    for mu in [0.02, 0.1] {
        let text = shot(&[("V", 700.0), ("front", 0.1), ("friction", mu)], FINE);
        cases.push(depth(format!("friction {mu}"), text, "n=10,20,40", closed_form(700.0, with_friction(mu), 0.0)));
    }
    let text = shot(&[("V", 900.0), ("front", 0.1), ("B", 0.983), ("C", 0.983)], FINE);
    let exact = closed_form(900.0, [1.0, 0.302356, 0.106481481], 0.983);
    cases.push(depth("three terms".into(), text, "n=10,20,40", exact));
    cases
}

/// Returns N0, N1 (unused), N2 of CRH 3 with friction (reference, section 1).
fn with_friction(mu: f64) -> [f64; 3] {
    let psi: f64 = 3.0;
    let angle = 0.5 * PI - ((2.0 * psi - 1.0) / (2.0 * psi)).asin();
    let root = (4.0 * psi - 1.0).sqrt();
    let n0 = 1.0 + 4.0 * mu * psi * psi * angle - mu * (2.0 * psi - 1.0) * root;
    let n2 = (8.0 * psi - 1.0) / (24.0 * psi * psi) + mu * psi * psi * angle
        - mu * (2.0 * psi - 1.0) * (6.0 * psi * psi + 4.0 * psi - 1.0) * root / (24.0 * psi * psi);
    [n0, 0.0, n2]
}

/// Returns the depth of a fully embedded nose: integral of m V dV / (alpha + gamma V + beta V^2) from 0 to V, by
/// Simpson's rule.
pub fn closed_form(v: f64, [n0, n1, n2]: [f64; 3], b: f64) -> f64 {
    let area = PI * A * A;
    let alpha = area * 5.0394 * Y * n0;
    let (gamma, beta) = (area * b * (RHO * Y).sqrt() * n1, area * 0.983 * RHO * n2);
    let term = |u: f64| MASS * u / (alpha + gamma * u + beta * u * u);
    let steps = 2000;
    let h = v / f64::from(steps);
    let weight = |i: i32| {
        if i == 0 || i == steps {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    (0..=steps).map(|i| weight(i) * term(h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// Returns refinements of the increments of `ogive.inp` under direct user control, with so many facets that their error
/// is negligible.
pub fn increments(scheme: &str) -> Vec<StudyCase> {
    let of = |(v, exact): (f64, f64)| {
        let card = format!("*Dynamic, Explicit, direct user control, load velocity={scheme}\n 4.e-6, 1.e-3\n");
        let text = shot(&[("V", v), ("front", 0.1), ("n", 4000.0)], &card);
        depth(format!("increments {scheme}, {v} m/s"), text, "increment=4,2,1,0.5", exact)
    };
    [(569.0, 59.612643939e-3), (1147.0, 221.597433967e-3)].map(of).into()
}

/// A hemisphere with equal angles has N2 = 1/2 for any number of facets, so that only the error of the increments
/// remains.
pub fn hemisphere() -> StudyCase {
    let card = "*Dynamic, Explicit, direct user control\n 4.e-6, 1.e-3\n";
    let text = shot(&[("V", 800.0), ("front", 0.1), ("CRH", 0.5)], card);
    depth("hemisphere, increments".into(), text, "increment=4,2,1", closed_form(800.0, [1.0, 0.0, 0.5], 0.0))
}

/// Returns the case of a flat face through a plate: the residual velocity.
pub fn flat_face() -> StudyCase {
    let text = "*Node\n 1, 0., 0.\n 2, 0.005, 0.\n 3, 0.005, 0.05\n 9, 0., 0.01\n*Element, type=RAX2, elset=E\n 1, 1, 2\n 2, 2, 3\n\
        *Element, type=MASS, elset=M\n 9, 9\n*Mass, elset=M\n 0.05\n*Rigid Body, ref node=9, elset=E\n*Nset, nset=REF\n 9\n*Surface, name=S\n E, SNEG\n\
        *Material, name=AL\n*Density\n 2710.,\n*Cavity Expansion, yield=276.e6\n 5., 0., 1.\n*Target, name=T, front=-0.01, direction=-1\n AL, 0.004\n\
        *Initial Conditions, type=VELOCITY\n REF, 2, -500.\n*Step\n*Dynamic, Explicit, accuracy=1e-3\n , 1.e-4\n*Dsload, target=T\n S, CAVITY\n\
        *Output, history, frequency=1\n*Node Output, nset=REF\n V2\n*End Step\n";
    let area = PI * 0.005 * 0.005;
    let (alpha, beta) = (area * 5.0 * 276e6, area * 2710.0);
    let decay = (-2.0 * beta * 0.004 / 0.05_f64).exp();
    let exact = (decay * (500.0 * 500.0 + alpha / beta) - alpha / beta).sqrt();
    StudyCase {
        name: "flat face through a plate".into(),
        deck: with_parameters(text.into()),
        refine: "increment=1,0.5,0.25",
        quantity: "-final(V2@REF)".into(),
        exact,
    }
}

/// Returns the cases of Lame's sphere, a = 10 and b = 20 mm, internal pressure 1 MPa: u(a) = 4.000e-5 mm, u(b) = 1.5e-5
/// mm.
pub fn lame() -> Vec<StudyCase> {
    let make = |n: usize| {
        let around = 2 * n;
        let place = |i: usize, j: usize| {
            let (radius, angle) = (10.0 * (1.0 + i as f64 / n as f64), 0.5 * PI * j as f64 / around as f64);
            if j == around { [0.0, radius] } else { [radius * angle.cos(), radius * angle.sin()] }
        };
        grid(n, around, false, place)
            + &material(200e3, 0.3, 7.85e-9, "*Nset, nset=INNER\n 1,\n")
            + &format!(
                "*Nset, nset=OUTER\n {},\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 2.e-4, 1.\n",
                n + 1
            )
            + "*Step\n*Dynamic, Explicit, element by element\n , 3.e-4\n*Boundary\n J0, 2, 2\n*Dsload, amplitude=RAMP\n I0, P, 1.\n\
               *Output, history, frequency=1\n*Node Output, nset=INNER\n U1\n*Node Output, nset=OUTER\n U1\n*End Step\n"
    };
    let case = |(node, exact): (&str, f64)| StudyCase {
        name: format!("Lame's sphere, {node}"),
        deck: with_elements(make),
        refine: "n=4,8,16",
        // The mean over a period removes the remaining vibration.
        quantity: format!("mean(U1@{node}, 2.2e-4, 3e-4)"),
        exact,
    };
    [("INNER", 4e-5), ("OUTER", 1.5e-5)].map(case).into()
}

/// Returns the case of Blake's cavity, displacement of the wall after 100 microseconds.
pub fn blake() -> StudyCase {
    let make = |per_radius: usize| {
        let around = per_radius;
        let place = |i: usize, j: usize| {
            let (radius, angle) = (0.1 + 0.1 * i as f64 / per_radius as f64, 0.5 * PI * j as f64 / around as f64);
            if j == around { [0.0, radius] } else { [radius * angle.cos(), radius * angle.sin()] }
        };
        grid(3 * per_radius, around, false, place)
            + &material(62.5e9, 0.25, 3000.0, "*Nset, nset=WALL\n 1,\n")
            + "*Step\n*Dynamic, Explicit, element by element\n , 1.e-4\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J0, 2, 2\n*Dsload\n I0, P, 1.e6\n\
               *Output, history, frequency=1\n*Node Output, nset=WALL\n U1\n*End Step\n"
    };
    StudyCase {
        name: "Blake's cavity".into(),
        deck: with_elements(make),
        refine: "n=10,20,40",
        quantity: "final(U1@WALL)".into(),
        exact: 0.974715628e-6,
    }
}

/// Modulus of uniaxial strain 4, density 1, so c = 2; nu = 1/4.
const WAVE_YOUNG: f64 = 4.0 * 1.25 * 0.5 / 0.75;

/// Returns a column in uniaxial strain, fixed at the foot, in its first mode: v = 1e-6 sin(k z) cos(k c t), k = pi/2.
/// The elements are squares, so that the increment is the same fraction of the stable one on every mesh.
pub fn wave(n: usize, dynamic: &str) -> String {
    let columns = (n / 10).max(1);
    let mut deck = grid(columns, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64])
        + &material(WAVE_YOUNG, 0.25, 1.0, "*Initial Conditions, type=VELOCITY\n");
    for (j, i) in (0..=n).flat_map(|j| (0..=columns).map(move |i| (j, i))) {
        let v = 1e-6 * (0.5 * PI * j as f64 / n as f64).sin();
        writeln!(deck, " {}, 2, {v:.17e}", 1 + i + j * (columns + 1)).expect("text");
    }
    deck + &format!("*Nset, nset=TOP\n {}\n*Step\n{dynamic}", n * (columns + 1) + 1)
        + "*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Output, history, number interval=10\n\
           *Node Output, nset=TOP\n U2, V2\n*End Step\n"
}

/// Returns the case of the whole velocity field of the wave, with mesh and increments refined together.
pub fn wave_in_space() -> StudyCase {
    StudyCase {
        name: "standing wave, field".into(),
        deck: with_elements(|n| wave(n, "*Dynamic, Explicit, element by element, scale factor=0.8\n , 9.3\n")),
        refine: "n=10,20,40",
        quantity: "norm(V2, 1e-6*sin(pi/2*z0)*cos(pi*t))".into(),
        exact: 0.0,
    }
}

/// Returns the case of the final velocity of its top.
pub fn wave_top() -> StudyCase {
    let exact = 1e-6 / PI * (PI * 9.3_f64).sin();
    StudyCase { quantity: "final(U2@TOP)".into(), name: "standing wave, top".into(), exact, ..wave_in_space() }
}

/// Refinement of the increments alone on a fixed mesh, compared with the frequency of the mesh, 2 c/h sin(k h / 2) with
/// the lumped mass.
pub fn wave_in_time() -> StudyCase {
    let h: f64 = 1.0 / 20.0;
    let omega = 2.0 * 2.0 / h * (0.25 * PI * h).sin();
    StudyCase {
        name: "standing wave, increments".into(),
        deck: with_parameters(wave(20, "*Dynamic, Explicit, direct user control\n 0.015, 9.3\n")),
        refine: "increment=1,0.5,0.25",
        quantity: "final(U2@TOP)".into(),
        exact: 1e-6 / omega * (omega * 9.3).sin(),
    }
}

/// Returns the case of a mass on a column of the same mass in its first mode, beta tan beta = 1: u = v sin(beta) /
/// omega sin(omega t).
pub fn mass_on_column() -> StudyCase {
    const BETA: f64 = 0.860_333_589_019_38;
    let make = |n: usize| {
        let mut deck = grid(1, n, false, |i, j| [i as f64 / n as f64, j as f64 / n as f64])
            + &material(WAVE_YOUNG, 0.25, 1.0, "*Node, nset=REF\n 900, 0., 1.\n*Initial Conditions, type=VELOCITY\n");
        // The last row of nodes belongs to the rigid body.
        for k in 0..2 * n {
            writeln!(deck, " {}, 2, {:.17e}", k + 1, 1e-6 * (BETA * (k / 2) as f64 / n as f64).sin()).expect("text");
        }
        // The radius of the column is one element.
        let mass = PI / (n * n) as f64;
        deck + &format!(
            " 900, 2, {:.17e}\n*Element, type=MASS, elset=POINT\n 900, 900\n*Mass, elset=POINT\n {mass:.17e}\n\
             *Rigid Body, ref node=900, tie nset=J1\n*Step\n*Dynamic, Explicit, element by element, scale factor=0.8\n , 9.3\n",
            1e-6 * BETA.sin()
        ) + "*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Output, history, number interval=10\n*Node Output, nset=REF\n U2\n*End Step\n"
    };
    let omega = 2.0 * BETA;
    StudyCase {
        name: "mass on a column".into(),
        deck: with_elements(make),
        refine: "n=10,20,40",
        quantity: "final(U2@REF)".into(),
        exact: 1e-6 * BETA.sin() / omega * (omega * 9.3).sin(),
    }
}

/// Verney's shell stops at half its inner radius (cm, g, microseconds). The exact result is that of a rigid-plastic
/// shell, so the material is ten times as stiff as beryllium, whose elastic strain alone is 0.1 %. With the filtered
/// viscosity the error of coarse meshes changes sign, and a coarser setting meets a target by chance.
pub fn verney() -> StudyCase {
    let make = |n: usize| {
        let (bulk, shear): (f64, f64) = (11.80, 15.1);
        let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
        let nu = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
        let radius = |i: usize| 8.0 + 2.0 * i as f64 / n as f64;
        let ray = |j: usize| {
            let angle = 0.5 * PI * j as f64 / n as f64;
            if j == n { [0.0, 1.0] } else { [angle.cos(), angle.sin()] }
        };
        let mut deck = grid(n, n, false, |i, j| ray(j).map(|x| radius(i) * x))
            + &material(young, nu, 1.845, "*Plastic\n 0.0033, 0.\n*Nset, nset=INNER\n 1,\n");
        deck += "*Initial Conditions, type=VELOCITY\n";
        for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
            let v = -0.0619787076 * (8.0 / radius(i)).powi(2);
            let ([r, z], node) = (ray(j), 1 + i + j * (n + 1));
            write!(deck, " {node}, 1, {:e}\n {node}, 2, {:e}\n", v * r, v * z).expect("text");
        }
        deck + "*Step\n*Dynamic, Explicit, element by element\n , 105.\n"
            + WHOLE_VISCOSITY
            + "*Boundary\n J0, 2, 2\n J1, 1, 1\n*Output, history, time interval=0.1\n\
                *Node Output, nset=INNER\n U1\n*End Step\n"
    };
    StudyCase {
        name: "Verney's shell".into(),
        deck: with_elements(make),
        refine: "n=6,12,24",
        quantity: "8 + min(U1@INNER)".into(),
        exact: 4.0,
    }
}

/// Returns the case of Noh's planar gas: density 4 after the shock, of the element that was at two fifths.
pub fn noh() -> StudyCase {
    let make = |n: usize| {
        let watched = 2 * n / 5;
        grid(1, n, false, |i, j| [i as f64 * 0.01, j as f64 / n as f64])
            + "*Initial Conditions, type=VELOCITY\n ALL, 2, -1.\n"
            + &format!(
                "*Solid Section, elset=SOLID, material=GAS\n*Material, name=GAS\n*Density\n 1.,\n*Eos, type=IDEAL GAS\n {:.17e}, 0.\n\
                 *Specific Heat\n 1.,\n*Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 1e-6\n*Elset, elset=ONE\n {watched}\n",
                2.0 / 3.0
            )
            + "*Step\n*Dynamic, Explicit, element by element\n , 0.6\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Output, history, number interval=60\n\
               *Element Output, elset=ONE\n DENSITY, PRESS\n*End Step\n"
    };
    StudyCase {
        name: "Noh's gas, planar".into(),
        deck: with_elements(make),
        refine: "n=25,50,100,200",
        quantity: "final(DENSITY@ONE)".into(),
        exact: 4.0,
    }
}

/// Returns the case of an elastic-plastic piston: stress after both shocks, after J. R. Asay's two-wave structure;
/// small strains.
pub fn piston() -> StudyCase {
    let (length, speed) = (0.1, 0.5);
    let (e, density, limit, c_l, c_p) = (68.9e11, 2710e2, 552e6, 6175.478, 5042.257);
    let make = move |m: usize| {
        grid(1, m, false, |i, j| [0.01 + 0.01 * i as f64, length * j as f64 / m as f64])
            + &material(
                e,
                1.0 / 3.0,
                density,
                &format!("*Plastic\n 276.e6, 0.\n*Elset, elset=BEHIND\n {},\n", 3 * m / 8),
            )
            + &format!(
                "*Initial Conditions, type=VELOCITY\n J0, 2, {speed}\n*Step\n*Dynamic, Explicit, element by element\n , 1.3e-5\n{WHOLE_VISCOSITY}"
            )
            + &format!("*Boundary\n ALL, 1, 1\n*Boundary, type=VELOCITY\n J0, 2, 2, {speed}\n")
            + "*Output, history, number interval=1\n*Element Output, elset=BEHIND\n S22\n*End Step\n"
    };
    let elastic = limit / (density * c_l);
    StudyCase {
        name: "elastic-plastic piston".into(),
        deck: with_elements(make),
        refine: "n=40,80,160",
        quantity: "-final(S22@BEHIND)".into(),
        exact: limit + density * c_p * (speed - elastic),
    }
}

/// Returns all cases.
pub fn all() -> Vec<StudyCase> {
    let mut cases = facets();
    cases.extend(increments("PREDICTED"));
    cases.extend(increments("LAGGED"));
    cases.extend(lame());
    let single =
        [hemisphere, flat_face, blake, wave_in_space, wave_top, wave_in_time, mass_on_column, verney, noh, piston];
    cases.extend(single.map(|case| case()));
    cases
}
