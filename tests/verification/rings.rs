//! Steel discs and rings stretched along r, with the Johnson-Cook law, plastic heating and thermal expansion, compared
//! with ABAQUS.
//!
//! Goal: large strain, flow, plastic heating and thermal expansion of one element over the whole path; a ring of four
//! elements with conduction.
//! Source: ABAQUS/Explicit 6.14 on the same meshes, read from the curves in the documentation of DynELA 3 (O. Pantale,
//! `Documentation/Figures/Samples/Element` of the repository `pantale/DynELA-v3.0`, four to five digits); closed form
//! below.

use crate::common::solid::{column, grid, run};

/// 42CrMo4 with the constants of the source; mm, t, s, degrees.
const STEEL: &str = "*Material, name=STEEL\n*Density\n 7.83e-9,\n*Elastic\n 206e3, 0.3\n*Conductivity\n 34.,\n\
     *Expansion\n 1.23e-5,\n*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 4.6e8,\n*Plastic, hardening=JOHNSON COOK\n\
     806., 614., 0.168, 1.1, 1540., 20.\n*Rate Dependent, type=JOHNSON COOK\n 0.0089, 1.\n\
     *Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Amplitude, name=A\n 0., 0., 0.01, 1.\n";

/// Returns the values of a history at the given tenths of the step.
fn at_tenths(history: &[(f64, f64)], tenths: &[usize]) -> Vec<f64> {
    let near = |t: f64| history.iter().min_by(|a, b| (a.0 - t).abs().total_cmp(&(b.0 - t).abs())).expect("rows").1;
    tenths.iter().map(|&k| near(1e-3 * k as f64)).collect()
}

fn largest_error(found: &[f64], expected: &[f64]) -> f64 {
    found.iter().zip(expected).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

/// Disc of 10 x 10 mm whose rim moves 10 mm outward in 10 ms with fixed axial faces; the strain is uniform. With
/// J = (1 + u/10)^2, bulk modulus K, expansion coefficient a and von Mises stress q (z is compressed, r and hoop are
/// equal):
/// S11 = K ln J + q/3 - 3 K a (T - 20), S22 = S11 - q.
#[test]
fn stretched_disc_matches_closed_form_and_abaqus() {
    let mut deck = grid(1, 1, false, |i, j| [10.0 * i as f64, 10.0 * j as f64]);
    deck += "*Nset, nset=RIM\n 2,\n*Solid Section, elset=SOLID, material=STEEL\n";
    deck += STEEL;
    deck += "*Step\n*Dynamic, Explicit, adiabatic, element by element\n , 0.01\n*Boundary\n I0, 1, 1\n ALL, 2, 2\n\
             *Boundary, amplitude=A\n I1, 1, 1, 10.\n*Output, history, time interval=1e-3\n\
             *Node Output, nset=RIM\n U1\n*Element Output, elset=SOLID\n S11, S22, MISES, PEEQ, TEMP\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let of = |name: &str| at_tenths(&column(&deck, &memory, &format!("{name}@SOLID")), &[2, 4, 6, 8, 10]);
    let (radial, axial, mises, strain, heat) = (of("S11"), of("S22"), of("MISES"), of("PEEQ"), of("TEMP"));
    println!("disc: S11 {radial:.0?} S22 {axial:.0?} Mises {mises:.1?} PEEQ {strain:.4?} T {heat:.2?}");
    let bulk = 206e3 / (3.0 * (1.0 - 2.0 * 0.3));
    // Rows are written at the increment next to their time.
    let moved = at_tenths(&column(&deck, &memory, "U1@RIM"), &[2, 4, 6, 8, 10]);
    for (i, u) in moved.into_iter().enumerate() {
        let pressed = bulk * 2.0 * (1.0 + 0.1 * u).ln() - 3.0 * bulk * 1.23e-5 * (heat[i] - 20.0);
        assert!((radial[i] / (pressed + mises[i] / 3.0) - 1.0).abs() < 1e-5, "S11 at {u} mm: {}", radial[i]);
        assert!((axial[i] / (pressed - 2.0 * mises[i] / 3.0) - 1.0).abs() < 1e-5, "S22 at {u} mm: {}", axial[i]);
    }
    // Reading accuracy of the curves, and one increment.
    assert!(largest_error(&radial, &[62794.0, 115521.0, 161187.0, 201466.0, 237495.0]) < 3e-4, "{radial:?}");
    assert!(largest_error(&axial, &[61537.0, 114238.0, 159899.0, 200179.0, 236213.0]) < 3e-4, "{axial:?}");
    assert!(largest_error(&mises, &[1257.6, 1282.5, 1288.2, 1286.9, 1282.4]) < 5e-4, "{mises:?}");
    assert!(largest_error(&strain, &[0.1163, 0.2189, 0.3079, 0.3864, 0.4567]) < 1e-3, "{strain:?}");
    assert!(largest_error(&heat, &[55.02, 87.67, 116.3, 141.5, 164.1]) < 2e-3, "{heat:?}");
}

/// Ring of 10 x 10 mm with inner radius 10 mm, 2 x 2 coupled elements, fixed axial faces, inner face moved 10 mm
/// outward in 10 ms. Compared are means over the four elements.
#[test]
fn expanded_ring_matches_abaqus() {
    let mut deck = grid(2, 2, false, |i, j| [10.0 + 5.0 * i as f64, 5.0 * j as f64]);
    deck = deck.replace("CAX4R", "CAX4RT");
    deck += "*Nset, nset=OUTSIDE\n 3,\n*Solid Section, elset=SOLID, material=STEEL\n";
    for e in 1..=4 {
        deck += &format!("*Elset, elset=E{e}\n {e},\n");
    }
    deck += STEEL;
    deck += "*Step\n*Dynamic Temperature-displacement, Explicit\n , 0.01\n*Boundary\n J0, 2, 2\n J1, 2, 2\n\
             *Boundary, amplitude=A\n I0, 1, 1, 10.\n*Output, history, time interval=1e-3\n\
             *Node Output, nset=OUTSIDE\n U1\n";
    for e in 1..=4 {
        deck += &format!("*Element Output, elset=E{e}\n S11, S22, MISES, PEEQ, TEMP\n");
    }
    deck += "*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let tenths = [2, 4, 6, 8, 10];
    let of = |name: &str| -> Vec<f64> {
        let each: Vec<Vec<f64>> =
            (1..=4).map(|e| at_tenths(&column(&deck, &memory, &format!("{name}@E{e}")), &tenths)).collect();
        (0..tenths.len()).map(|i| each.iter().map(|list| list[i]).sum::<f64>() / 4.0).collect()
    };
    let outside = at_tenths(&column(&deck, &memory, "U1@OUTSIDE"), &tenths);
    let (radial, axial, mises, strain, heat) = (of("S11"), of("S22"), of("MISES"), of("PEEQ"), of("TEMP"));
    println!(
        "ring: S11 {radial:.1?} S22 {axial:.1?} Mises {mises:.1?} PEEQ {strain:.4?} T {heat:.1?} U1 {outside:.3?}"
    );
    assert!(outcome.energy.drift < 1e-6, "{:e}", outcome.energy.drift);
    // Differences of hourglass control, conduction and increments of the two codes, and the reading accuracy.
    assert!(largest_error(&radial, &[-357.1, -313.8, -272.1, -235.4, -204.0]) < 5e-3, "{radial:?}");
    assert!(largest_error(&axial, &[358.1, 419.1, 465.8, 502.0, 530.0]) < 5e-3, "{axial:?}");
    assert!(largest_error(&mises, &[1249.9, 1280.4, 1288.7, 1287.5, 1281.4]) < 1e-3, "{mises:?}");
    assert!(largest_error(&strain, &[0.1066, 0.2136, 0.315, 0.4108, 0.5013]) < 1e-3, "{strain:?}");
    assert!(largest_error(&outside, &[1.096, 2.304, 3.62, 5.026, 6.508]) < 1e-3, "{outside:?}");
    // Plastic work heats the mass at the initial density here; an expanding volume takes less heat.
    let rise = |list: &[f64]| list.iter().map(|t| t - 20.0).collect::<Vec<_>>();
    assert!(largest_error(&rise(&heat), &rise(&[51.23, 84.63, 116.9, 147.5, 176.4])) < 1e-2, "{heat:?}");
}
