//! Reference nodes and tied surfaces: `*MPC`, `*COUPLING`, `*EQUATION` with a reference node without elements, `*TIE`,
//! `*RIGID BODY` with TIE NSET and with elements of a deformable type.
//!
//! Goal: frequencies, momenta, reactions and waves of constrained bodies.
//! Source: closed forms of vibrating columns and bars; momentum and centre of mass. The tolerance and its reason are
//! stated at each test.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::user::Routines;

use crate::common::prepared;
use crate::common::solid::{column, grid, last, material, run};

/// Modulus of uniaxial strain; density 1 gives wave speed 2 for height 1 and radius 0.1.
const MODULUS: f64 = 4.0;
const ROWS: usize = 20;
const AREA: f64 = PI * 0.01;

/// Constraints between the top of a column and node 900.
const HANGING: [(&str, &str); 8] = [
    ("MPC BEAM", "*Mpc\n BEAM, J1, REF\n"),
    ("MPC TIE", "*Mpc\n TIE, J1, 900\n"),
    ("MPC PIN", "*Mpc\n PIN, J1, 900\n"),
    ("kinematic coupling", "*Coupling, constraint name=C, ref node=REF, surface=J1\n*Kinematic\n"),
    ("kinematic coupling along z", "*Coupling, constraint name=C, ref node=900, surface=J1\n*Kinematic\n 2, 2\n"),
    ("distributing coupling", "*Coupling, constraint name=C, ref node=900, surface=J1\n*Distributing\n"),
    ("equation", "*Equation\n 2\n J1, 2, 1., 900, 2, -1.\n"),
    ("rigid body", "*Rigid Body, ref node=900, tie nset=J1\n"),
];

/// Returns a column along z in uniaxial strain whose top is constrained to node 900.
fn constrained_column(link: &str, more: &str) -> String {
    let nu: f64 = 0.25;
    let e = MODULUS * (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
    grid(2, ROWS, false, |i, j| [0.05 * i as f64, j as f64 / ROWS as f64])
        + &material(e, nu, 1.0, "*Node, nset=REF\n 900, 0.3, 1.2\n")
        + link
        + more
}

fn mass_on_reference(mass: f64) -> String {
    format!("*Element, type=MASS, elset=POINT\n 900, 900\n*Mass, elset=POINT\n {mass:e}\n")
}

/// Returns the nodal share of the mass of rings of radial width 0.05, by row sums, times 2 pi.
fn row_share(i: usize) -> f64 {
    let h = 0.05;
    2.0 * PI * [h * h / 6.0, h * h / 3.0 + h * (0.5 * h + h / 6.0), h * (0.5 * h + h / 3.0)][i]
}

/// Returns the mass of node n of the column, counted from 0.
fn node_mass(n: usize) -> f64 {
    let half = if n / 3 == 0 || n / 3 == ROWS { 0.5 } else { 1.0 };
    half * row_share(n % 3) / ROWS as f64
}

fn rising_zeros(history: &[(f64, f64)]) -> Vec<f64> {
    let rising = history.windows(2).filter(|w| w[0].1 < 0.0 && w[1].1 >= 0.0);
    rising.map(|w| w[0].0 - w[0].1 * (w[1].0 - w[0].0) / (w[1].1 - w[0].1)).collect()
}

/// beta tan beta = mass of the column over the attached mass; omega = beta c / L.
#[test]
fn mass_on_a_reference_node_has_the_period_of_theory() {
    let beta: f64 = 0.860_333_589_019_38; // beta tan beta = 1
    let velocity = |z: f64| 1e-6 * (beta * z).sin();
    let mut start = mass_on_reference(AREA) + "*Initial Conditions, type=VELOCITY\n";
    for n in 0..3 * ROWS {
        writeln!(start, " {}, 2, {:e}", n + 1, velocity((n / 3) as f64 / ROWS as f64)).expect("text");
    }
    writeln!(start, " 900, 2, {:e}", velocity(1.0)).expect("text");
    for (name, link) in HANGING {
        let deck = constrained_column(link, &start)
            + "*Step\n*Dynamic, Explicit\n , 40.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n\
               *Output, history, frequency=1\n*Node Output, nset=REF\n U2\n*Node Output, nset=J1\n U2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let motion = column(&deck, &memory, "U2@REF");
        let zeros = rising_zeros(&motion);
        let period = (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64;
        // Second order: 1.1e-4 with 20 rows, 2e-5 with 40, as for a mass in the mesh.
        let error = period * 2.0 * beta / (2.0 * PI) - 1.0;
        println!("{name}: period error {error:.1e}, drift {:.1e}", outcome.energy.drift);
        assert!(error.abs() < 2e-4, "{name}: period error {error:e}");
        assert!(outcome.energy.drift < 2e-3, "{name}: {:e}", outcome.energy.drift);
        // Constrained nodes move with their reference node; that of a distributing coupling moves with their mean.
        if !name.starts_with("distributing") {
            let (node, reference) =
                (last(&deck, &memory, &format!("U2@{}", 3 * ROWS + 3)), motion.last().expect("a row").1);
            // Rounding of coordinates of size 1.
            assert!((node - reference).abs() < 1e-14, "{name}: {node:e} {reference:e}");
        }
    }
}

/// A force on a massless reference node accelerates the centre of mass of the column, to rounding.
#[test]
fn force_on_a_massless_reference_node_moves_the_centre_of_mass() {
    for (name, link) in HANGING {
        let deck = constrained_column(link, "")
            + "*Step\n*Dynamic, Explicit\n , 3.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n*Cload\n 900, 2, 1.e-4\n\
               *Output, history, number interval=20\n*Node Output, nset=ALL\n V2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let mut worst = 0.0_f64;
        for (time, values) in &memory.rows {
            let momentum: f64 = (0..3 * ROWS + 3).map(|n| node_mass(n) * values[n]).sum();
            worst = worst.max((momentum - 1e-4 * time).abs() / (1e-4 * 3.0));
        }
        println!("{name}: momentum error {worst:.1e}, drift {:.1e}", outcome.energy.drift);
        // Sums of some hundred terms over some hundred increments.
        assert!(worst < 1e-11, "{name}: momentum error {worst:e}");
        // The force starts at full value, whose trapezoidal work is of first order in the increment.
        assert!(outcome.energy.drift < 5e-3, "{name}: {:e}", outcome.energy.drift);
    }
}

/// Prescribed motion of a massless reference node: its reaction is the force E A u / L in the column, and opposite to
/// that of the foot.
#[test]
fn reference_node_reaction_is_the_column_force() {
    for (name, link) in HANGING {
        let deck = constrained_column(link, "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 100., 1.\n")
            + "*Step\n*Dynamic, Explicit\n , 100.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, amplitude=RAMP\n 900, 2, 2, 1.e-6\n\
               *Output, history, number interval=50\n*Node Output, nset=REF\n U2, RF2\n*Node Output, nset=J0\n RF2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let force = last(&deck, &memory, "RF2@REF");
        let foot: f64 = (1..=3).map(|n| last(&deck, &memory, &format!("RF2@{n}"))).sum();
        let expected = MODULUS * AREA * 1e-6;
        println!("{name}: reaction error {:.1e}, foot {:.1e}", force / expected - 1.0, foot / expected + 1.0);
        // Residual vibration of a motion prescribed over 50 wave periods.
        assert!((force / expected - 1.0).abs() < 5e-3, "{name}: {force:e} {expected:e}");
        assert!((foot / expected + 1.0).abs() < 5e-3, "{name}: {foot:e} {expected:e}");
        assert!(outcome.energy.drift < 1e-3, "{name}: {:e}", outcome.energy.drift);
    }
}

/// Returns two stacked columns of radius 1 with `below` and `above` cells along the radius, rows of height 0.1 /
/// `fine`, and an initial gap.
fn stacked_columns(below: usize, above: usize, fine: usize, gap: f64, tie: &str) -> String {
    let rows = 10 * fine;
    let mut text = String::new();
    for (name, base, columns, foot) in [("LOW", 0, below, 0.0), ("HIGH", 100_000, above, 1.0 + gap)] {
        writeln!(text, "*Node, nset={name}").expect("text");
        for j in 0..=rows {
            for i in 0..=columns {
                let [r, z] = [i as f64 / columns as f64, foot + j as f64 / rows as f64];
                writeln!(text, " {}, {r:.17e}, {z:.17e}", base + 1 + i + j * (columns + 1)).expect("text");
            }
        }
        writeln!(text, "*Element, type=CAX4R, elset={name}").expect("text");
        for j in 0..rows {
            for i in 0..columns {
                let a = base + 1 + i + j * (columns + 1);
                let b = a + columns + 1;
                writeln!(text, " {}, {a}, {}, {}, {b}", base + 1 + i + j * columns, a + 1, b + 1).expect("text");
            }
        }
    }
    let first = (rows - 1) * below + 1;
    let middle = 1 + (rows / 2) * (below + 1);
    write!(
        text,
        "*Elset, elset=SOLID\n LOW, HIGH\n*Elset, elset=ETOP, generate\n {first}, {}\n*Surface, name=TOP\n ETOP, S3\n\
         *Elset, elset=EFOOT, generate\n 100001, {}\n*Surface, name=FOOT\n EFOOT, S1\n*Nset, nset=BASE, generate\n 1, {}\n\
         *Nset, nset=GAUGES, generate\n {middle}, {}\n{tie}",
        first + below - 1,
        100_000 + above,
        below + 1,
        middle + below
    )
    .expect("text");
    let nu: f64 = 0.25;
    let e = MODULUS * (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
    text + &material(e, nu, 1.0, "")
}

/// Returns the nodal share of the mass of a disc of radius 1 divided into `columns` rings, by row sums.
fn ring_share(columns: usize, i: usize) -> f64 {
    let (h, r) = (1.0 / columns as f64, i as f64 / columns as f64);
    let inside = if i > 0 { h * (0.5 * r - h / 6.0) } else { 0.0 };
    let outside = if i < columns { h * (0.5 * r + h / 6.0) } else { 0.0 };
    2.0 * (inside + outside)
}

/// A pulse along z passes a tie between nonmatching meshes. Measured is its reflection, as a plane wave (mean over a
/// section) and at any node.
#[test]
fn wave_passes_a_tie_of_nonmatching_meshes() {
    let back = |below: usize, above: usize, fine: usize| {
        // Velocity pulse of length 0.8 and duration 0.4; the gauges are in the middle of the lower column.
        let mut text = stacked_columns(below * fine, above * fine, fine, 0.0, "*Tie, name=T\n FOOT, TOP\n");
        text += "*Amplitude, name=PULSE\n";
        for i in 0..=80 {
            let t = 0.005 * f64::from(i);
            writeln!(text, " {t}, {:e}", (PI * t / 0.4).sin().powi(2)).expect("text");
        }
        text += " 9., 0.\n*Step\n*Dynamic, Explicit\n , 1.1\n*Bulk Viscosity\n 0., 0.\n*Boundary\n LOW, 1, 1\n HIGH, 1, 1\n\
                 *Boundary, type=VELOCITY, amplitude=PULSE\n BASE, 2, 2, 1.e-6\n\
                 *Output, history, frequency=1\n*Node Output, nset=GAUGES\n V2\n*End Step\n";
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        // Trapezoidal work of the prescribed motion, of second order; the same for matching meshes.
        assert!(outcome.energy.drift < 3e-2 / (fine * fine) as f64, "{:e}", outcome.energy.drift);
        // The pulse leaves the gauges at 0.25 + 0.4; its reflection from the tie arrives at 0.75.
        let rows = memory.rows.iter().filter(|r| r.0 > 0.75);
        rows.fold([0.0_f64; 2], |[plane, any], (_, v)| {
            let mean: f64 = v.iter().enumerate().map(|(i, v)| ring_share(below * fine, i) * v).sum();
            let largest = v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            [plane.max(mean.abs() / 1e-6), any.max(largest / 1e-6)]
        })
    };
    // Matching meshes show only the numerical dispersion of the pulse.
    let alike: Vec<[f64; 2]> = [2, 4, 8].map(|fine| back(3, 3, fine)).to_vec();
    let found: Vec<[f64; 2]> = [2, 4, 8].map(|fine| back(3, 4, fine)).to_vec();
    let orders: Vec<f64> = found.windows(2).map(|w| (w[0][0] / w[1][0]).log2()).collect();
    println!("tie of nonmatching meshes: reflection {found:?}, orders {orders:.2?}; matching: {alike:?}");
    // The numerical dispersion of the pulse: 3.9e-3, 9.0e-4 and 5.9e-5, at any node as in the mean.
    assert!(orders.iter().all(|o| *o > 1.5), "{found:?} {orders:?}");
    assert!(found[2][0] < 2e-4 && found[2][1] < 2e-4, "{found:?}");
}

/// Slave nodes with an initial distance are moved to the master surface without strain, or remain in place; momentum is
/// conserved in both cases. Moved nodes are listed.
#[test]
fn tied_nodes_are_adjusted_and_conserve_momentum() {
    for (gap, tie, place) in [
        (0.005, "*Tie, name=T\n FOOT, TOP\n", 1.0),
        (0.005, "*Tie, name=T, adjust=NO\n FOOT, TOP\n", 1.005),
        (0.02, "*Tie, name=T, adjust=YES, position tolerance=0.03\n FOOT, TOP\n", 1.0),
    ] {
        let text = stacked_columns(3, 4, 1, gap, &format!("{tie}*Nset, nset=ONE\n 100002\n"))
            + "*Initial Conditions, type=VELOCITY\n HIGH, 2, -1.e-3\n HIGH, 1, 1.e-4\n*Step\n*Dynamic, Explicit\n , 5.\n\
               *Bulk Viscosity\n 0., 0.\n*Output, history, number interval=10\n*Node Output, nset=ONE\n COOR2\n\
               *Node Output, nset=LOW\n V2\n*Node Output, nset=HIGH\n V2\n*Energy Output\n ALLSE\n*End Step\n";
        let job = prepared(&text, &[], &Routines::none());
        let listed = job.diagnostics.render(&job.deck.sources);
        let moves = listed.contains("5 nodes of tie T are moved") && listed.contains(&format!(" {gap:.3e},"));
        assert_eq!((moves, listed.contains("P125")), (place == 1.0, place == 1.0), "{listed}");
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        // The height of the lowest row of the upper column follows from the adjusted nodes.
        let height = |j: usize, foot: f64| if j == 0 { foot } else { 0.1 };
        let weight = |columns: usize, n: usize, foot: f64| {
            let (i, j) = (n % (columns + 1), n / (columns + 1));
            let below = if j > 0 { height(j - 1, foot) } else { 0.0 };
            ring_share(columns, i) * 0.5 * (below + if j < 10 { height(j, foot) } else { 0.0 })
        };
        let momentum = |values: &[f64]| {
            let low: f64 = (0..44).map(|n| weight(3, n, 0.1) * values[1 + n]).sum();
            low + (0..55).map(|n| weight(4, n, 1.1 + gap - place) * values[45 + n]).sum::<f64>()
        };
        let first = &memory.rows[0].1;
        assert!((first[0] - place).abs() < 1e-12, "{} {place}", first[0]);
        let all: Vec<f64> = memory.rows.iter().map(|r| momentum(&r.1)).collect();
        let worst = all.iter().fold(0.0_f64, |m, p| m.max((p / all[0] - 1.0).abs()));
        println!("gap {gap}: momentum error {worst:.1e}, drift {:.1e}", outcome.energy.drift);
        assert!(worst < 1e-11, "{worst:e}");
        // The impact velocity is discontinuous over one row, and the increment is the largest stable one.
        assert!(outcome.energy.drift < 1.5e-2 && outcome.energy.strain > 0.0, "{:?}", outcome.energy);
    }
}

/// A rigid punch made of deformable element types, with a mass on its reference node and a pad tied to it, falls: the
/// centre of mass follows gravity and an applied force.
#[test]
fn dropped_punch_with_tied_pad_conserves_momentum() {
    let text = stacked_columns(4, 3, 1, 0.0, "")
        + "*Node, nset=REF\n 900000, 0., 3.\n*Element, type=MASS, elset=POINT\n 900000, 900000\n*Mass, elset=POINT\n 2.\n\
           *Rigid Body, ref node=900000, elset=HIGH\n*Tie, name=T\n TOP, FOOT\n\
           *Initial Conditions, type=VELOCITY\n 900000, 2, -0.01\n LOW, 2, -0.01\n*Step\n*Dynamic, Explicit\n , 5.\n\
           *Bulk Viscosity\n 0., 0.\n*Dload\n , GRAV, 0.001, 0., -1.\n*Cload\n 900000, 2, -0.002\n\
           *Output, history, number interval=20\n*Node Output, nset=REF\n V2\n*Node Output, nset=LOW\n V2\n*End Step\n";
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    // The upper column has volume pi; the top row of nodes of the lower column belongs to the rigid body.
    let weight = |n: usize| PI * ring_share(4, n % 5) * 0.1 * if n / 5 == 0 || n / 5 == 10 { 0.5 } else { 1.0 };
    let mass = 2.0 + 2.0 * PI;
    let mut worst = 0.0_f64;
    for (time, values) in &memory.rows {
        let momentum = (2.0 + PI) * values[0] + (0..55).map(|n| weight(n) * values[1 + n]).sum::<f64>();
        let expected = -0.01 * mass - (0.001 * mass + 0.002) * time;
        worst = worst.max((momentum / expected - 1.0).abs());
    }
    println!("dropped punch: momentum error {worst:.1e}, drift {:.1e}", outcome.energy.drift);
    assert!(worst < 1e-11, "{worst:e}");
    assert!(outcome.energy.drift < 1e-3, "{:e}", outcome.energy.drift);
    // Rigid elements limit no increment and store no energy; the strain energy is that of the pad.
    assert!(outcome.energy.strain > 0.0);
}

/// Mass scaling of elements with constrained nodes: the added mass and the increment are those specified, and the motion is
/// that of a column of the scaled density, to rounding.
#[test]
fn mass_scaling_includes_constrained_nodes() {
    for (name, link) in HANGING {
        let deck = |scaling: &str, density: &str| {
            constrained_column(link, &mass_on_reference(AREA)).replacen("*Density\n 1e0,", density, 1)
                + "*Initial Conditions, type=VELOCITY\n J0, 2, 1.e-3\n*Step\n*Dynamic, Explicit, element by element\n , 1.\n"
                + scaling
                + "*Boundary\n ALL, 1, 1\n*Dload\n , GRAV, 0.001, 0., -1.\n*Output, history, number interval=4\n\
                   *Node Output, nset=REF\n V2\n*Node Output, nset=ALL\n V2\n*End Step\n"
        };
        let text = deck("*Fixed Mass Scaling, factor=4.\n", "*Density\n 1e0,");
        assert!(text.contains("*Density\n 1e0,"), "{text}");
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let added = outcome.steps[0].added_mass.expect("scaled");
        assert!((added / (3.0 * AREA) - 1.0).abs() < 1e-12, "{name}: {added}");
        let places = outcome.steps[0].added_mass_at.expect("scaled");
        let at_end = 3.0 * AREA * 0.5 / ROWS as f64;
        assert!(((places.linked_nodes + places.rigid_bodies) / at_end - 1.0).abs() < 1e-12, "{name}: {places:?}");
        assert_eq!(places.rigid_bodies > 0.0, name == "rigid body");
        let (dense, other) = run(&deck("", "*Density\n 4e0,"));
        assert_eq!(outcome.increments, dense.increments, "{name}");
        let [a, b] = [&memory, &other].map(|memory| memory.rows.last().expect("a row").1.clone());
        let largest = b.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let apart = a.iter().zip(&b).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())) / largest;
        println!("{name}: {apart:.1e} apart, drift {:.1e}", outcome.energy.drift);
        assert!(apart < 1e-9, "{name}: {apart:e}");
        let dt = 3.0 * outcome.steps[0].largest_increment;
        for card in ["Fixed Mass Scaling, type=uniform", "Variable Mass Scaling, frequency=3, type=set equal dt"] {
            let target = run(&deck(&format!("*{card}, dt={dt:.17e}\n"), "*Density\n 1e0,")).0;
            assert_eq!(target.halt, None);
            let reached = target.steps[0].largest_increment;
            assert!((reached / dt - 1.0).abs() < 1e-3, "{name}: {card}: {reached} of {dt}");
        }
    }
}

/// Invalid links are errors whose message names the remedy, and omitted slave nodes cause a note.
#[test]
fn invalid_links_are_errors_with_a_remedy() {
    let step =
        "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n J0, 2, 2\n*Boundary, type=VELOCITY\n 900, 2, 2, 1.\n*End Step\n";
    let shown = |text: &str| {
        let prepared = revolve::job::prepare_text("bad.inp", text, &[], &Routines::none());
        (prepared.diagnostics.has_errors(), prepared.diagnostics.render(&prepared.deck.sources))
    };
    for (link, from, to, words) in [
        ("*Mpc\n BEAM, J1, REF\n", "", "", ""),
        ("*Mpc\n SLIDER, J1, REF\n", "", "", "supported: BEAM, TIE, PIN"),
        ("*Mpc\n BEAM, J1\n", "", "", "M102"),
        ("*Mpc\n TIE, J1, J0\n*Mpc\n TIE, J0, 900\n", "", "", "prescribe only the motion of the reference node"),
        ("*Mpc\n BEAM, J1, REF\n", " 900, 2, 2, 1.", " J1, 2, 2, 1.\n 900, 2, 2, 1.", "P018"),
        ("*Mpc\n BEAM, J1, REF\n*Rigid Body, ref node=1, tie nset=J1\n", "", "", "REF NODE"),
        ("*Coupling, constraint name=C, ref node=REF, surface=J1\n", "", "", "*KINEMATIC nor *DISTRIBUTING"),
        ("*Kinematic\n", "", "", "M105"),
        ("*Coupling, constraint name=C, ref node=REF, surface=NONE\n*Kinematic\n", "", "", "M114"),
        ("*Tie, name=T\n J1, J0\n", "", "", "POSITION TOLERANCE="),
        ("*Tie, name=T\n J1\n", "", "", "slave surface, master surface"),
        ("*Mpc\n BEAM, J1, REF\n", "*Boundary, type", "*Cload\n 901, 2, 1.\n*Boundary, type", "P003"),
        (
            "*Coupling, constraint name=C, ref node=REF, surface=J1\n*Distributing\n",
            "*Boundary, type",
            "*Cload\n 900, 1, 1.\n*Boundary, type",
            "P062",
        ),
    ] {
        let text = (constrained_column(link, "*Node\n 901, 5., 5.\n") + step).replacen(from, to, 1);
        let (errors, diagnostics) = shown(&text);
        assert_eq!(errors, !words.is_empty(), "{link}: {diagnostics}");
        assert!(diagnostics.contains(words), "{link}: {diagnostics}");
    }
    // A slave surface that extends beyond its master.
    let text = stacked_columns(3, 4, 1, 0.0, "*Tie, name=T\n TOP, FOOT\n")
        .replace("EFOOT, generate\n 100001, 100004", "EFOOT, generate\n 100001, 100002")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let (errors, diagnostics) = shown(&text);
    assert!(!errors && diagnostics.contains("P061") && diagnostics.contains("2 of 4 nodes"), "{diagnostics}");
}
