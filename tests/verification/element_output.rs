//! Output variables of deformable elements, compared with closed forms.
//!
//! Goal: LE, PE, ER, SENER, PENER, EVOL, DENSITY, STATUS and DT have their documented values, and requesting them
//! changes no result.
//! Source: logarithmic strain of a stretched bar, simple shear with the Jaumann rate, energies of the whole model.

use std::fmt::Write as _;

use crate::common;
use crate::common::solid::{column, grid, last, material, run};

/// Returns a grid of 2 by 2 cells from r = 1 to 3 and z = 0 to 2 with prescribed velocities at all nodes.
fn moving_grid(velocity: impl Fn([f64; 2]) -> [f64; 2], duration: f64, outputs: &str, more: &str) -> String {
    let place = |i: usize, j: usize| [1.0 + i as f64, j as f64];
    let mut deck = grid(2, 2, false, place) + &material(1000.0, 0.3, 2.0, more);
    for node in 1..=9 {
        write!(deck, "*Nset, nset=N{node}\n {node},\n").expect("text");
    }
    write!(deck, "*Step\n*Dynamic, Explicit, direct user control\n 1.e-4, {duration}\n").expect("text");
    deck += "*Bulk Viscosity\n 0., 0.\n*Boundary, type=VELOCITY\n";
    for node in 0..9 {
        let [v_r, v_z] = velocity(place(node % 3, node / 3));
        write!(deck, " N{}, 1, 1, {v_r:e}\n N{}, 2, 2, {v_z:e}\n", node + 1, node + 1).expect("text");
    }
    deck + outputs + "*End Step\n"
}

#[test]
fn stretched_bar_has_logarithmic_strain() {
    let outputs = "*Elset, elset=ONE\n 1,\n*Output, history, number interval=4\n*Element Output, elset=ONE\n LE, ER22, \
                   EVOL, DENSITY, STATUS, SENER, S22\n*Incrementation Output\n DT\n*Energy Output\n ALLSE\n";
    let deck = moving_grid(|[_, z]| [0.0, 0.5 * z], 1.0, outputs, "");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let value = |name: &str| last(&deck, &memory, &format!("{name}@ONE"));
    let strain = 1.5_f64.ln();
    // The midpoint of an increment is exact to second order: (5e-5)^2 / 3.
    assert!((value("LE22") / strain - 1.0).abs() < 1e-8, "{}", value("LE22"));
    assert!(value("LE11").abs() + value("LE33").abs() + value("LE12").abs() < 1e-10);
    // Strain rate at the middle of the last increment.
    assert!((value("ER22") * (1.5 - 0.25e-4) / 0.5 - 1.0).abs() < 1e-8, "{}", value("ER22"));
    let volume = std::f64::consts::PI * 3.0 * 1.5;
    assert!((value("EVOL") / volume - 1.0).abs() < 1e-9 && (value("DENSITY") * 1.5 / 2.0 - 1.0).abs() < 1e-9);
    assert_eq!(value("STATUS"), 1.0);
    assert!((last(&deck, &memory, "DT") / 1e-4 - 1.0).abs() < 1e-9);
    // E (1 - nu) / ((1 + nu) (1 - 2 nu)) = 1346.15; the energy is the work of this stress over the changing volume.
    let modulus = 1000.0 * 0.7 / (1.3 * 0.4);
    assert!((value("S22") / (modulus * strain) - 1.0).abs() < 1e-8);
    // int s dV = V0 m int ln(x) dx = V0 m (x ln x - x + 1), divided by the final volume.
    let work = modulus * (1.5 * strain - 0.5) / 1.5;
    assert!((value("SENER") / work - 1.0).abs() < 1e-7, "{} {work}", value("SENER"));
}

#[test]
fn strain_in_simple_shear_follows_the_jaumann_rate() {
    let outputs = "*Elset, elset=ONE\n 1,\n*Output, history, number interval=4\n*Element Output, elset=ONE\n LE\n";
    let deck = moving_grid(|[r, _]| [0.0, r], 1.0, outputs, "");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    // Jaumann rate with constant D and W: E12 = sin(g)/2, E11 = -E22 = (cos(g) - 1)/2 at the shear g = 1.
    let expected = [("LE12", 1_f64.sin()), ("LE11", 0.5 * (1_f64.cos() - 1.0)), ("LE22", 0.5 * (1.0 - 1_f64.cos()))];
    for (name, expected) in expected {
        // The rotation of an increment of 1e-4 is exact to third order, but the strain increment is half an increment
        // late.
        let got = last(&deck, &memory, &format!("{name}@ONE"));
        assert!((got - expected).abs() < 2e-4 * expected.abs().max(0.3), "{name} {got} {expected}");
    }
    assert!(last(&deck, &memory, "LE33@ONE").abs() < 1e-12);
}

#[test]
fn element_energies_add_up_to_the_model_energies() {
    let plastic = "*Plastic\n 10., 0.\n 30., 0.1\n";
    let outputs = "*Output, history, number interval=10\n*Element Output, elset=SOLID\n LE, PE, PEEQ, S, SENER, PENER, EVOL\n\
                   *Energy Output\n ALLSE, ALLPD\n*Output, field, number interval=2, variable=PRESELECT\n";
    let deck = moving_grid(|[r, z]| [-0.02 * r, 0.1 * z], 1.0, outputs, plastic);
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let value = |name: &str, e: usize| last(&deck, &memory, &format!("{name}@{e}"));
    let (shear, bulk) = (1000.0 / 2.6, 1000.0 / 1.2);
    let (mut elastic_energy, mut plastic_energy) = (0.0, 0.0);
    for e in 1..=4 {
        let tensor = |name: &str| ["11", "22", "33"].map(|c| value(&format!("{name}{c}"), e));
        let (total, flow, stress) = (tensor("LE"), tensor("PE"), tensor("S"));
        let dilation: f64 = total.iter().sum();
        assert!(flow.iter().sum::<f64>().abs() < 1e-12, "flow keeps the volume: {flow:?}");
        for i in 0..3 {
            let hooke = bulk * dilation + 2.0 * shear * (total[i] - flow[i] - dilation / 3.0);
            // The law is exact without spin; the rest is rounding of 1e4 additions.
            assert!((hooke - stress[i]).abs() < 1e-8, "{hooke} {}", stress[i]);
        }
        // Loading is proportional, so the equivalent plastic strain of the components is PEEQ.
        let equivalent = (2.0 / 3.0 * flow.iter().map(|x| x * x).sum::<f64>()).sqrt();
        assert!(equivalent > 0.05 && (equivalent / value("PEEQ", e) - 1.0).abs() < 1e-9, "{equivalent}");
        elastic_energy += value("SENER", e) * value("EVOL", e);
        plastic_energy += value("PENER", e) * value("EVOL", e);
    }
    // Sums of the same terms in another order.
    assert!((elastic_energy / last(&deck, &memory, "ALLSE") - 1.0).abs() < 1e-9, "{elastic_energy}");
    assert!((plastic_energy / last(&deck, &memory, "ALLPD") - 1.0).abs() < 1e-9, "{plastic_energy}");
    let frame = memory.frames.last().expect("a frame");
    let names: Vec<&str> = frame.point_fields.iter().chain(&frame.cell_fields).map(|f| f.name.as_str()).collect();
    for name in ["U", "V", "A", "RF", "S", "LE", "PE", "PEEQ"] {
        assert!(names.contains(&name), "PRESELECT lacks {name}: {names:?}");
    }
    assert!(!names.contains(&"STATUS") && !names.contains(&"SENER"), "{names:?}");
}

#[test]
fn requested_strains_change_no_bit_of_the_motion() {
    let deck = |more: &str| {
        let outputs = format!("*Output, history, number interval=10\n*Energy Output\n ALLIE, ALLPD\n{more}");
        moving_grid(|[r, z]| [-0.03 * r * z, 0.1 * z * r], 0.5, &outputs, "*Plastic\n 10., 0.\n 30., 0.1\n")
    };
    let (plain, asked) = (deck(""), deck("*Element Output, elset=SOLID\n LE, PE\n"));
    let ((_, quiet), (_, recorded)) = (run(&plain), run(&asked));
    for name in ["ALLIE", "ALLPD"] {
        assert_eq!(column(&plain, &quiet, name), column(&asked, &recorded, name), "{name}");
    }
}

/// One of two materials is plastic: the other has no plastic strain, and neither has temperatures.
#[test]
fn absent_element_variables_are_not_written() {
    let outputs = "*Output, history, number interval=2\n*Element Output, elset=SOLID\n PEEQ, S22\n\
                   *Output, field, number interval=2\n*Element Output\n PEEQ, PE, MISES, TEMP\n";
    let flows = "*Plastic\n 10., 0.\n 30., 0.1\n";
    let sets = "*Elset, elset=HARD\n 2, 4\n*Elset, elset=SOFT\n 1, 3\n*Solid Section, elset=SOFT";
    let second = "*Solid Section, elset=HARD, material=E\n\
                  *Material, name=E\n*Density\n 2.,\n*Elastic\n 1000., 0.3\n";
    let deck = moving_grid(|[_, z]| [0.0, 0.1 * z], 0.5, outputs, flows)
        .replace("*Solid Section, elset=SOLID", sets)
        .replace("*Step\n", &format!("{second}*Step\n"));
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let prepared = common::prepared(&deck, &[], &revolve::user::Routines::none());
    let columns: Vec<&str> = prepared.plan.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(columns, ["PEEQ@1", "PEEQ@3", "S22@1", "S22@2", "S22@3", "S22@4"]);
    assert!(prepared.plan.ledger.unused.iter().any(|u| u.what == "TEMP"), "{:?}", prepared.plan.ledger.unused);
    let frame = memory.frames.last().expect("a frame");
    let names: Vec<&str> = frame.cell_fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["PEEQ", "PE", "MISES"]);
    for field in &frame.cell_fields {
        let cells = field.values.chunks(field.components);
        let absent: Vec<bool> = cells.map(|c| c.iter().all(|v| v.is_nan())).collect();
        let flows = field.name != "MISES";
        assert_eq!(absent.iter().filter(|a| **a).count(), if flows { 2 } else { 0 }, "{}", field.name);
        assert!(field.values.iter().filter(|v| !v.is_nan()).all(|v| v.is_finite()));
    }
}

/// Principal strains and rates have the invariants of their tensors; LE12, PE12 and ER12 are engineering shears and
/// enter with half their values.
#[test]
fn principal_values_match_tensor_invariants() {
    let deck = grid(2, 2, false, |i, j| [1.0 + i as f64 + 0.2 * j as f64, j as f64])
        + &material(1000.0, 0.3, 2.0, "*Plastic\n 1., 0.\n 2., 1.\n")
        + "*Initial Conditions, type=VELOCITY\n J1, 1, 1.\n J1, 2, -1.\n*Step\n*Dynamic, Explicit\n , 0.05\n*Boundary\n J0, 1, 2\n\
           *Output, history, number interval=3\n*Element Output, elset=SOLID\n LE, LEP, PE, PEP, PEMAG, ER, ERP, ERV\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let prepared = common::prepared(&deck, &[], &revolve::user::Routines::none());
    let row = &memory.rows.last().expect("rows").1;
    let value = |name: String| row[prepared.plan.columns.iter().position(|c| c.name == name).expect("a column")];
    let near = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-13 * scale, "{a} {b}");
    for element in 1..=4 {
        for (tensor, principal) in [("LE", "LEP"), ("PE", "PEP"), ("ER", "ERP")] {
            let [rr, zz, hoop, rz] = ["11", "22", "33", "12"].map(|c| value(format!("{tensor}{c}@{element}")));
            let [a, b, c] = ["1", "2", "3"].map(|i| value(format!("{principal}{i}@{element}")));
            let size = a.abs().max(c.abs());
            assert!(a <= b && b <= c && rz.abs() > 0.01 * size, "{tensor}: {a} {b} {c}, shear {rz}");
            near(a + b + c, rr + zz + hoop, size);
            near(a * a + b * b + c * c, rr * rr + zz * zz + hoop * hoop + 0.5 * rz * rz, size * size);
            near(a * b * c, hoop * (rr * zz - 0.25 * rz * rz), size * size * size);
            if tensor == "PE" {
                near(value(format!("PEMAG@{element}")), (2.0 / 3.0 * (a * a + b * b + c * c)).sqrt(), size);
            }
            if tensor == "ER" {
                near(value(format!("ERV@{element}")), rr + zz + hoop, size);
            }
        }
    }
}
