//! Soil, concrete, ceramics and porous metal: laws whose strength depends on pressure or porosity.
//!
//! Goal: the elastic limit of a ceramic under uniaxial strain, the shock in a compacting metal, the fracture energy of concrete,
//! the energy of deleted elements, and clear refusals.
//! Source: closed forms, and the shock relations of a porous metal solved independently; the tolerance is stated at each test.

use revolve::study::strength::{self, StrengthRequest};
use revolve::user::Routines;
use revolve::{deck, job, model};

use crate::common;
use crate::common::solid::{column, grid, last, run};

/// Returns a column of `m` square elements with the material `cards` named `name`, whose sides do not move radially if
/// `is_held`.
fn bar(m: usize, length: f64, name: &str, cards: &str, is_held: bool) -> String {
    let size = length / m as f64;
    let held =
        if is_held { "*Boundary\n I0, 1, 1\n I1, 1, 1\n J0, 2, 2\n" } else { "*Boundary\n I0, 1, 1\n J0, 2, 2\n" };
    grid(1, m, false, |i, j| [size * i as f64, size * j as f64])
        + &format!("*Solid Section, elset=SOLID, material={name}\n*Material, name={name}\n{cards}{held}")
}

/// The stress at which a ceramic first yields under uniaxial strain solves q(p) = 2 G e and p(e): 2.822, 15.80 and 5.108 GPa
/// for alumina, boron carbide and float glass with the constants below. Tolerance 0.2 %: the rows of the history are that
/// far apart.
#[test]
fn ceramic_yields_at_its_strength_under_uniaxial_strain() {
    for (constants, expected) in [
        (
            "3.7e-9, 90160., 0.93, 0.6, 0.31, 0.6, 0., 1.\n 200., , , 2793.33, 1460., 1., 0.005, 1.\n , 0., 0., 0., 130950., 0., 0., 0.",
            2822.0,
        ),
        (
            "2.51e-9, 197e3, 0.927, 0.67, 0.7, 0.85, 0., 1.\n 260., , 0.2, 19e3, 8710., 1., 0.001, 0.5\n , 0., 0., 0., 233e3, -593e3, 2.8e6, 0.",
            15800.0,
        ),
        (
            "2.53e-9, 30400., 0.93, 0.77, 0.088, 0.35, 0., 1.\n 150., , 0.5, 5950., 2920., 1., 0.053, 0.85\n , 0., 0., 0., 45400., -138e3, 290e3, 0.",
            5108.0,
        ),
    ] {
        let cards = format!("*Density\n 2.5e-9,\n*User Material, constants=24\n {constants}\n*Depvar\n 8,\n");
        let deck = bar(1, 1.0, "ABQ_JH2_CERAMIC", &cards, true)
            + "*Step\n*Dynamic, Explicit, direct user control\n 1.e-9, 7.e-6\n*Bulk Viscosity\n 0., 0.\n\
               *Boundary, type=VELOCITY\n J1, 2, 2, -1.e4\n*Output, history, frequency=1\n*Element Output, elset=SOLID\n \
               S22, PEEQ\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let strains = column(&deck, &memory, "PEEQ@SOLID");
        let first = strains.iter().position(|row| row.1 > 0.0).expect("plastic flow");
        let found = -column(&deck, &memory, "S22@SOLID")[first - 1].1;
        println!("{found} {expected}");
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    }
}

/// A piston at 1000 m/s closes all pores of aluminium with a porosity of .2. Mass, momentum and energy across the front and the
/// equation of state of the solid give 8520.3 MPa and V/V0 = .74649. Tolerance .2 %: bulk viscosity spreads the front.
#[test]
fn piston_compacts_porous_aluminium() {
    let cards = "*Density\n 2.7e-9,\n*Eos, type=USUP\n 5.35e6, 1.34, 2.\n*Eos Compaction\n 3.5e6, 0.2, 80., 700.\n";
    let deck = bar(200, 20.0, "POROUS", cards, true).replace(" J0, 2, 2\n", "")
        + "*Elset, elset=MID\n 50,\n*Step\n*Dynamic, Explicit\n , 3.e-6\n*Boundary, type=VELOCITY\n J0, 2, 2, 1.e6\n*Output, \
           history, number interval=10\n*Element Output, elset=MID\n PRESS, PALPH, EVOL\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 1e-9, "{}", outcome.energy.drift);
    let value = |name: &str| last(&deck, &memory, name);
    let volume = value("EVOL@MID") / column(&deck, &memory, "EVOL@MID")[0].1;
    println!("{} {volume} {}", value("PRESS@MID"), value("PALPH@MID"));
    assert!((value("PRESS@MID") / 8520.3 - 1.0).abs() < 2e-3 && (volume / 0.74649 - 1.0).abs() < 2e-3);
    assert_eq!(value("PALPH@MID"), 1.0);
}

/// Crushing of pores is dissipated: at zero stress after two depths of compaction no strain energy is left. The solid has no
/// thermal pressure, whose work would remain. Tolerance 1 % of the largest strain energy; without this account it was 90 %.
#[test]
fn strain_energy_of_compacted_pores_vanishes_with_the_stress() {
    let cards = "*Density\n 2.7e-9,\n*Eos, type=USUP\n 5.35e6, 1.34, 0.\n*Eos Compaction\n 3.5e6, 0.2, 80., 700.\n";
    // Unloading ends in tension, so that the history contains zero stress.
    for [compressed, unloaded] in [[-0.03, -0.026], [-0.09, -0.06]] {
        let deck = bar(1, 1.0, "POROUS", cards, true)
            + &format!(
                "*Amplitude, name=A\n 0., 0., 2.e-4, {compressed}, 4.e-4, {unloaded}\n*Step\n*Dynamic, Explicit\n , 4.e-4\n*Bulk \
                 Viscosity\n 0., 0.\n*Boundary, amplitude=A\n J1, 2, 2, 1.\n*Output, history, number interval=2000\n*Element \
                 Output, elset=SOLID\n PRESS\n*Energy Output\n ALLIE, ALLSE, ALLPD\n*End Step\n"
            );
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let values = |name: &str| column(&deck, &memory, name).into_iter().map(|row| row.1).collect::<Vec<_>>();
        let [pressures, stored] = [values("PRESS@SOLID"), values("ALLSE")];
        let largest = stored.iter().copied().fold(0.0, f64::max);
        let zero = (1000..pressures.len()).find(|&row| pressures[row] <= 0.0).expect("zero stress");
        let [left, work, spent] = [stored[zero], values("ALLIE")[zero], values("ALLPD")[zero]];
        println!("{compressed}: {left} of {largest}, ALLPD {spent} of {work}");
        assert!(left.abs() < 1e-2 * largest && spent > 0.9 * work, "{left} {largest} {spent} {work}");
    }
}

/// The work that tears an element with free sides is the fracture energy times the crack area, whatever its size. Tolerance
/// 1 %: strains are finite.
#[test]
fn crack_of_concrete_dissipates_the_fracture_energy() {
    let cards = "*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete \
                 Compression Hardening\n 30., 0.\n 30., 0.01\n*Concrete Tension Stiffening, type=GFI\n 2.5, 0.11\n";
    for size in [8.0, 20.0] {
        let deck = bar(1, size, "CONCRETE", cards, false)
            + "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 0.01, 1.\n*Step\n*Dynamic, Explicit\n , 0.01\n*Boundary, \
               amplitude=A\n J1, 2, 2, 0.095\n*Output, history, number interval=10\n*Energy Output\n ALLWK, ALLSE, ALLPD\n\
               *End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let per_area = last(&deck, &memory, "ALLPD") / (std::f64::consts::PI * size * size);
        println!("{size}: {per_area} of .11, ALLSE {:e}", last(&deck, &memory, "ALLSE"));
        assert!((per_area / 0.11 - 1.0).abs() < 1e-2, "{per_area}");
    }
}

/// Two triangles that form a square dissipate the fracture energy like one element. Tolerance 5 %: they crack one after the
/// other.
#[test]
fn crack_of_triangles_dissipates_the_fracture_energy() {
    let size = 8.0;
    let deck = grid(1, 1, true, |i, j| [size * i as f64, size * j as f64])
        + "*Solid Section, elset=SOLID, material=CONCRETE\n*Material, name=CONCRETE\n*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n\
           *Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete Compression Hardening\n 30., 0.\n 30., 0.01\n*Concrete \
           Tension Stiffening, type=GFI\n 2.5, 0.11\n*Boundary\n 1, 1, 2\n 2, 2, 2\n 3, 1, 1\n*Amplitude, name=A, \
           definition=SMOOTH STEP\n 0., 0., 0.01, 1.\n*Step\n*Dynamic, Explicit\n , 0.01\n*Boundary, amplitude=A\n 3, 2, 2, 0.095\n \
           4, 2, 2, 0.095\n*Output, history, number interval=10\n*Energy Output\n ALLPD\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let per_area = last(&deck, &memory, "ALLPD") / (std::f64::consts::PI * size * size);
    println!("{per_area} of .11");
    assert!((per_area / 0.11 - 1.0).abs() < 5e-2, "{per_area}");
}

/// The flow potential of the linear form has no rounding.
#[test]
fn eccentricity_of_the_linear_form_is_named() {
    let deck = |card: &str| {
        let cards = format!(
            "*Density\n 2.e-9,\n*Elastic\n 3000., 0.25\n*Drucker Prager{card}\n 35., 0.8, 10.\n*Drucker Prager Hardening\n 10., 0.\n"
        );
        bar(1, 1.0, "SOIL", &cards, true) + "*Step\n*Dynamic, Explicit\n , 1.e-6\n*End Step\n"
    };
    let found = messages(&deck(", eccentricity=0.2"));
    assert!(found.contains("P140") && found.contains("ECCENTRICITY=0.2 has no effect"), "{found}");
    let found = messages(&deck(""));
    assert!(!found.contains("ECCENTRICITY"), "{found}");
}

/// A deleted element has no recoverable energy, and the energy balance closes over its deletion in small increments. Tolerance
/// 1e-4 of the internal energy: elastic energies are per current volume, which changes by the strain.
#[test]
fn deleted_element_of_concrete_has_no_energy() {
    let cards = "*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete \
                 Compression Hardening\n 30., 0.\n 30., 0.01\n*Concrete Tension Stiffening\n 2.5, 0.\n 0.5, 0.005\n\
                 *Concrete Failure\n 0.002,\n";
    let deck = bar(1, 10.0, "CONCRETE", cards, false)
        + "*Step\n*Dynamic, Explicit, direct user control\n 2.e-8, 2.e-3\n*Boundary, type=VELOCITY\n J1, 2, 2, 20.\n*Output, \
           history, number interval=10\n*Element Output, elset=SOLID\n STATUS\n*Energy Output\n ALLIE, ALLSE, ALLPD, ALLDMD, \
           EROIE\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let value = |name: &str| last(&deck, &memory, name);
    assert_eq!(value("STATUS@SOLID"), 0.0);
    println!("drift {:e}, ALLIE {:e}, ALLSE {:e}", outcome.energy.drift, value("ALLIE"), value("ALLSE"));
    assert!(outcome.energy.drift < 1e-3 && value("ALLSE").abs() < 1e-4 * value("ALLIE"));
}

/// The stress of a meshless target of a Drucker-Prager material is that of the equivalent Mohr-Coulomb material.
#[test]
fn resistance_follows_the_cards() {
    let deck = |more: &str| {
        format!(
            "*Material, name=SOIL\n*Density\n 2.e-9,\n*Elastic\n 3000., 0.25\n{more}*Cavity Expansion, derive\n 5.e4, 4.e5, 8\n"
        )
    };
    let soil = "*Drucker Prager\n 35., 0.8, 10.\n*Drucker Prager Hardening\n 10., 0.\n";
    let model = common::model_of(&deck(soil), &[]);
    let law = model.materials[0].cavity.expect("a resistance");
    let slope = 35.0_f64.to_radians().tan();
    assert!((law.yield_stress / (10.0 * (1.0 - slope / 3.0)) - 1.0).abs() < 1e-12 && law.a > 5.0, "{law:?}");
}

/// Returns errors and warnings of a deck.
fn messages(deck: &str) -> String {
    let prepared = job::prepare_text("bad.inp", deck, &[], &Routines::none());
    prepared.diagnostics.render(&prepared.deck.sources)
}

#[test]
fn incomplete_and_contradictory_cards_are_refused() {
    let elastic = "*Elastic\n 100., 0.3\n";
    let concrete = "*Concrete Damaged Plasticity\n 35.,\n";
    for (cards, words) in [
        (format!("{elastic}*Drucker Prager\n 30., 1., 10.\n"), "without *DRUCKER PRAGER HARDENING"),
        (format!("{elastic}*Drucker Prager Hardening\n 1., 0.\n"), "without *DRUCKER PRAGER"),
        (format!("{elastic}*Drucker Prager\n 30., 1., 40.\n*Drucker Prager Hardening\n 1., 0.\n"), "create energy"),
        (format!("{elastic}*Drucker Prager\n 30., 0.5, 10.\n*Drucker Prager Hardening\n 1., 0.\n"), "0.778"),
        ("*Drucker Prager\n 30., 1., 10.\n*Drucker Prager Hardening\n 1., 0.\n".into(), "no *ELASTIC"),
        (format!("{elastic}*Cap Plasticity\n 1., 30., 0.5\n"), "without *CAP HARDENING"),
        (
            format!("{elastic}*Cap Plasticity\n 1., 30., 0.5\n*Cap Hardening\n 0.01, 1.5\n 0.1, 20.\n"),
            "exchange the columns",
        ),
        (format!("{elastic}{concrete}"), "without *CONCRETE COMPRESSION HARDENING"),
        (
            format!(
                "{elastic}{concrete}*Concrete Compression Hardening\n 1., 0.\n 1., 0.1\n*Concrete Tension Stiffening\n 0.1, 0.\n \
                 0.01, 0.01\n*Concrete Tension Damage, type=DISPLACEMENT\n 0., 0.\n 0.5, 0.1\n"
            ),
            "another abscissa",
        ),
        (
            format!(
                "{elastic}{concrete}*Concrete Compression Hardening\n 1., 0.\n 1., 0.1\n*Concrete Tension Stiffening\n 0.1, 0.\n \
                 0.01, 0.0001\n*Concrete Tension Damage\n 0., 0.\n 0.98, 0.0001\n"
            ),
            "does not increase",
        ),
        ("*Holmquist Johnson Cook\n 1., 1., 1., 0., 1., 1., 1., 1.\n".into(), "three data lines"),
        (format!("{elastic}*Porous Metal Plasticity\n 1.5, 1., 2.25\n"), "needs *PLASTIC"),
        (format!("{elastic}*Void Nucleation\n 0.3, 0.1, 0.04\n"), "without *POROUS METAL PLASTICITY"),
        (format!("{elastic}*Plastic\n 1., 0.\n*Potential\n 1., 0.3, 1.\n"), "not closed"),
        (
            format!("{elastic}*Plastic\n 1., 0.\n*Drucker Prager\n 30., 1., 10.\n*Drucker Prager Hardening\n 1., 0.\n"),
            "together with *PLASTIC",
        ),
        (
            format!(
                "{elastic}*Drucker Prager\n 30., 1., 10.\n*Drucker Prager Hardening\n 1., 0.\n*Cap Plasticity\n 1., 30., 0.5\n\
                 *Cap Hardening\n 1., 0.\n"
            ),
            "belongs to another law",
        ),
        (format!("{elastic}*Drucker Prager\n 30., 1., 10.\n*Drucker Prager Hardening\n 1., 0.1\n"), "must start at 0"),
        (format!("{elastic}*Eos Compaction\n 1., 0.2, 1., 2.\n"), "TYPE=USUP"),
        (
            format!(
                "{elastic}{concrete}*Concrete Compression Hardening\n 1., 0.\n 1., 0.1\n*Concrete Tension Stiffening\n 0.1, 0.\n \
                 0.01, 0.01\n*Concrete Failure\n ,\n"
            ),
            "no limit",
        ),
        ("*Eos, type=IDEAL GAS\n 1.,\n*Specific Heat\n 1.,\n*Eos Compaction\n 1., 0.2, 1., 2.\n".into(), "TYPE=USUP"),
    ] {
        let cards = format!("*Density\n 1.,\n{cards}");
        let deck = bar(1, 1.0, "M", &cards, true) + "*Step\n*Dynamic, Explicit\n , 1.e-3\n*End Step\n";
        let text = messages(&deck);
        assert!(text.contains("error") && text.contains(words), "{words}: {text}");
    }
    for name in ["ABQ_JH1_GLASS", "ABQ_JHB_GLASS"] {
        let cards = "*Density\n 1.,\n*User Material, constants=1\n 1.,\n";
        let deck = bar(1, 1.0, name, cards, true) + "*Step\n*Dynamic, Explicit\n , 1.e-3\n*End Step\n";
        let text = messages(&deck);
        assert!(text.contains("error") && text.contains("ABQ_JH2"), "{text}");
    }
}

/// A bar whose middle element is 2 % weaker cracks there: the work per area is the fracture energy on three meshes. The elements
/// share their axial motion only. Tolerance 2 % (1 %: strains are finite). In a bar whose elements also share their radial
/// motion, the neighbours hold the contraction of the cracked element, which costs further 4 to 17 %.
#[test]
fn crack_of_a_bar_dissipates_the_fracture_energy() {
    let concrete = |name: &str, strength: f64| {
        format!(
            "*Material, name={name}\n*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, \
             0.667\n*Concrete Compression Hardening\n 30., 0.\n 30., 0.01\n*Concrete Tension Stiffening, type=GFI\n {strength}, \
             0.11\n"
        )
    };
    for count in [10, 20, 40] {
        let size = 100.0 / f64::from(count);
        let mut nodes = String::from("*Node\n");
        let mut elements = String::from("*Element, type=CAX4R, elset=BAR\n");
        let (mut links, mut axis) = (String::new(), String::from("*Nset, nset=AXIS\n"));
        for j in 0..count {
            let (n, low, high) = (4 * j, size * f64::from(j), size * f64::from(j + 1));
            nodes += &format!(" {}, 0., {low}\n {}, {size}, {low}\n", n + 1, n + 2);
            nodes += &format!(" {}, {size}, {high}\n {}, 0., {high}\n", n + 3, n + 4);
            elements += &format!(" {}, {}, {}, {}, {}\n", j + 1, n + 1, n + 2, n + 3, n + 4);
            axis += &format!(" {}, {}\n", n + 1, n + 4);
            if j > 0 {
                links += &format!(
                    "*Equation\n 2\n {}, 2, 1., {n}, 2, -1.\n 2\n {}, 2, 1., {}, 2, -1.\n",
                    n + 1,
                    n + 2,
                    n - 1
                );
            }
        }
        let weak = count / 2 + 1;
        let deck = nodes
            + &elements
            + &format!(
                "*Elset, elset=WEAK\n {weak},\n*Elset, elset=LOW, generate\n 1, {}\n*Elset, elset=HIGH, generate\n {}, {count}\n\
                 *Nset, nset=TOP\n {}, {}\n*Nset, nset=BASE\n 1, 2\n",
                weak - 1,
                weak + 1,
                4 * count - 1,
                4 * count
            )
            + &axis
            + "*Solid Section, elset=WEAK, material=WEAK\n*Solid Section, elset=LOW, material=REST\n*Solid Section, elset=HIGH, \
               material=REST\n"
            + &concrete("WEAK", 2.45)
            + &concrete("REST", 2.5)
            + "*Boundary\n AXIS, 1, 1\n BASE, 2, 2\n"
            + &links
            + "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 0.01, 1.\n*Step\n*Dynamic, Explicit\n , 0.01\n*Boundary, \
               amplitude=A\n TOP, 2, 2, 0.2\n*Output, history, number interval=10\n*Energy Output\n ALLWK, ALLPD\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let per_area = last(&deck, &memory, "ALLPD") / (std::f64::consts::PI * size * size);
        println!("{count} elements: {per_area} of .11");
        assert!((per_area / 0.11 - 1.0).abs() < 2e-2, "{count}: {per_area}");
    }
}

/// A pressure pulse that reflects from the free face of a plate of concrete breaks off spalls; no place is prescribed. The
/// energy per area that cracks dissipate is within 5 % over meshes of 120, 160 and 240 elements, for pulses of 1.6, 2 and 2.4
/// times the tensile strength (0.9, 4.2 and 0.8 %; with 60 elements it is 5 to 6 % larger).
#[test]
fn spall_of_a_plate_dissipates_the_same_on_three_meshes() {
    let cards = "*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete \
                 Compression Hardening\n 300., 0.\n 300., 0.1\n*Concrete Tension Stiffening, type=GFI\n 2.5, 0.003\n";
    let (length, duration) = (60.0, 8e-6);
    let pulse: String = (0..=40)
        .map(|i| {
            let share = f64::from(i) / 40.0;
            format!(" {:e}, {:e}\n", duration * share, (std::f64::consts::PI * share).sin().powi(2))
        })
        .collect();
    for pressure in [4.0, 5.0, 6.0] {
        let energies = [120, 160, 240].map(|count| {
            let size = length / count as f64;
            let deck = grid(1, count, false, |i, j| [size * i as f64, size * j as f64])
                + &format!("*Solid Section, elset=SOLID, material=CONCRETE\n*Material, name=CONCRETE\n{cards}")
                + &format!("*Amplitude, name=PULSE\n{pulse} 1., 0.\n*Boundary\n ALL, 1, 1\n")
                + "*Step\n*Dynamic, Explicit, element by element\n , 40.e-6\n*Dsload, amplitude=PULSE\n"
                + &format!(
                    " J0, P, {pressure}\n*Output, history, number interval=4\n*Energy Output\n ALLPD\n*End Step\n"
                );
            let (outcome, memory) = run(&deck);
            assert_eq!(outcome.halt, None);
            last(&deck, &memory, "ALLPD") / (std::f64::consts::PI * size * size)
        });
        let [least, most] =
            [energies.iter().copied().fold(f64::INFINITY, f64::min), energies.iter().copied().fold(0.0, f64::max)];
        println!("{pressure}: {energies:?}, spread {}", most / least - 1.0);
        assert!(most / least < 1.05, "{pressure}: {energies:?}");
    }
}

/// First yield and peak of a law by its own update, and in closed form: Drucker-Prager, its cap, Johnson-Holmquist 2,
/// Holmquist-Johnson-Cook below its crush pressure, concrete damaged plasticity and Gurson. Tolerance 1e-4 of the largest
/// von Mises stress of the surface.
#[test]
fn yield_surface_of_each_law_matches_its_closed_form() {
    let tangent = 40.0_f64.to_radians().tan();
    let soil = |p: f64| p * tangent + (1.0 - tangent / 3.0) * 20.0;
    // Cap: R = .4, alpha = .03, d = 5, pb = 40.
    let transition = 1.03 - 0.03 / 40.0_f64.to_radians().cos();
    let centre = (40.0 - 0.4 * 5.0) / (1.0 + 0.4 * tangent);
    let height = 5.0 + centre * tangent;
    let powder = |p: f64| {
        if p < centre { f64::NAN } else { transition * (height * height - ((p - centre) / 0.4).powi(2)).sqrt() }
    };
    let ceramic = |p: f64| 1.5 * (2790.0 - 1460.0) * 0.93 * ((p + 200.0) / 1460.0).powf(0.6);
    let impacted =
        |p: f64| if (0.0..16.0).contains(&p) { 48.0 * (0.79 + 1.6 * (p / 48.0).powf(0.61)) } else { f64::NAN };
    // A = (f - 1)/(2 f - 1), C = 3 (1 - Kc)/(2 Kc - 1); all principal stresses are compressive.
    let (a, c) = (0.16 / 1.32, 3.0 * (1.0 - 0.667) / (2.0 * 0.667 - 1.0));
    let cracked = |p: f64| {
        let q = ((1.0 - a) * 15.0 + (3.0 * a + c) * p) / (1.0 + c / 3.0);
        if q / 3.0 < p { q } else { f64::NAN }
    };
    let voids = |p: f64| {
        let f = 0.02;
        300.0 * (1.0 + 2.25 * f * f - 3.0 * f * (1.5 * p / 300.0).cosh()).sqrt()
    };
    let elastic = "*Density\n 2.4e-9,\n*Elastic\n 30000., 0.2\n";
    type Surface<'a> = (&'a str, String, &'a dyn Fn(f64) -> f64);
    let cases: [Surface<'_>; 6] = [
        ("SOIL", format!("{elastic}*Drucker Prager\n 40., 1., 10.\n*Drucker Prager Hardening\n 20., 0.\n"), &soil),
        (
            "POWDER",
            format!("{elastic}*Cap Plasticity\n 5., 40., 0.4, 0., 0.03\n*Cap Hardening\n 40., 0.\n 400., 0.1\n"),
            &powder,
        ),
        (
            "ABQ_JH2_CERAMIC",
            "*Density\n 3.7e-9,\n*User Material, constants=24\n 3.7e-9, 90160., 0.93, 0.6, 0.31, 0.6, 0., 1.\n 200., , , 2790., \
             1460., 1., 0.005, 1.\n , 0., 0., 0., 130950., 0., 0., 0.\n*Depvar\n 8,\n"
                .into(),
            &ceramic,
        ),
        (
            "IMPACTED",
            "*Density\n 2.4e-9,\n*Holmquist Johnson Cook\n 14860., 0.79, 1.6, 0.007, 0.61, 48., 4., 1.\n 0.01, 7., 16., 0.001, \
             800., 0.1, 0.04, 1.\n 85.e3, -171.e3, 208.e3, 0.\n"
                .into(),
            &impacted,
        ),
        (
            "CRACKED",
            format!(
                "{elastic}*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete Compression Hardening\n 15., 0.\n 30., \
                 0.0015\n*Concrete Tension Stiffening\n 2.6, 0.\n 0.2, 0.0024\n"
            ),
            &cracked,
        ),
        (
            "VOIDS",
            format!("{elastic}*Plastic\n 300., 0.\n 400., 1.\n*Porous Metal Plasticity, relative density=0.98\n 1.5, 1., 2.25\n"),
            &voids,
        ),
    ];
    for (name, cards, closed_form) in cases {
        let (deck, _) = deck::read_text("law.inp", &format!("*Node\n 1, 0., 0.\n*Material, name={name}\n{cards}"), &[]);
        let material = model::build(&deck).0.materials.pop().expect("a material");
        let request = StrengthRequest { confinements: vec![0.0, 10.0, 100.0], strain: 0.05, length: 1.0 };
        let curves = strength::curves(&material, &request).expect("a law");
        let largest = curves.surface.iter().map(|point| point[1]).fold(0.0, f64::max);
        let compared: Vec<_> = curves.surface.iter().filter(|[p, _]| closed_form(*p).is_finite()).collect();
        let worst = compared.iter().map(|[p, q]| (q - closed_form(*p)).abs() / largest).fold(0.0, f64::max);
        println!("{name}: {} of {} points, {worst:.1e}", compared.len(), curves.surface.len());
        assert!(compared.len() > 3 && worst < 1e-4, "{name}: {worst} {:?}", curves.surface);
        assert_eq!(curves.paths.len(), 4);
        let peaks: Vec<f64> =
            curves.paths[..3].iter().map(|path| path.points.iter().map(|p| p.mises).fold(0.0, f64::max)).collect();
        if name == "SOIL" {
            for (peak, cell) in peaks.iter().zip([0.0, 10.0, 100.0]) {
                let expected = 20.0 + cell * tangent / (1.0 - tangent / 3.0);
                assert!((peak / expected - 1.0).abs() < 1e-6, "{peak} {expected}");
            }
        }
        if name == "CRACKED" {
            for (peak, cell) in peaks.iter().zip([0.0, 10.0, 100.0]) {
                let expected = 30.0 + cell * (3.0 * a + c) / (1.0 - a);
                println!("{peak} {expected}");
                assert!((peak / expected - 1.0).abs() < 1e-4, "{peak} {expected}");
            }
        }
    }
}
