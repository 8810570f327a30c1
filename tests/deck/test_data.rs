//! Constants of rubber that are fitted to test data.

use revolve::deck;
use revolve::model::{self, DeviatoricEnergy, Model};

fn read(form: &str, cards: &str) -> (Model, String) {
    let text = format!("*Material, name=RUBBER\n*Density\n 1.1e-9,\n*Hyperelastic, {form}, test data input\n{cards}");
    let (deck, _) = deck::read_text("t.inp", &text, &[]);
    let (model, diagnostics) = model::build(&deck);
    (model, diagnostics.render(&deck.sources))
}

fn constants(model: &Model) -> Vec<(f64, usize, usize)> {
    let law = model.materials[0].hyperelastic.as_ref().expect("a law");
    let DeviatoricEnergy::Polynomial(terms) = &law.shape else { panic!("a polynomial") };
    terms.clone()
}

fn near(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-9, "{value}, expected {expected}");
}

const C10: f64 = 0.3;
const C01: f64 = 0.05;

/// Nominal stresses of the Mooney-Rivlin energy (Treloar, The Physics of Rubber Elasticity, chapter 5): uniaxial
/// `2 (l - l^-2) (C10 + C01 / l)`, equibiaxial `2 (l - l^-5) (C10 + C01 l^2)`, pure shear `2 (l - l^-3) (C10 + C01)`.
fn mooney_rivlin() -> String {
    let mut cards = String::from("*Uniaxial Test Data\n");
    for l in [0.7_f64, 1.2, 1.5, 2.0, 3.0] {
        cards += &format!(" {:e}, {}\n", 2.0 * (l - l.powi(-2)) * (C10 + C01 / l), l - 1.0);
    }
    cards += "*Biaxial Test Data\n";
    for l in [1.1_f64, 1.5, 2.0] {
        cards += &format!(" {:e}, {}\n", 2.0 * (l - l.powi(-5)) * (C10 + C01 * l * l), l - 1.0);
    }
    cards += "*Planar Test Data\n";
    for l in [1.2_f64, 2.0] {
        cards += &format!(" {:e}, {}\n", 2.0 * (l - l.powi(-3)) * (C10 + C01), l - 1.0);
    }
    cards
}

/// Data of a Mooney-Rivlin energy give its constants, in its own form and as terms of a higher order; the pressures of
/// `p = -2 (J - 1) / D1` give D1.
#[test]
fn fitted_constants_are_those_of_the_data() {
    let volumetric = "*Volumetric Test Data\n 0., 1.\n 20., 0.99\n 60., 0.97\n";
    let (model, messages) = read("mooney-rivlin", &(mooney_rivlin() + volumetric));
    assert!(!messages.contains("error[") && !messages.contains("warning["), "{messages}");
    let terms = constants(&model);
    near(terms[0].0, C10);
    near(terms[1].0, C01);
    near(model.materials[0].hyperelastic.as_ref().expect("a law").compressibility[0], 1e-3);
    assert!(messages.contains("fitted to 12 measured values: C10 = 0.300000, C01 = 0.050000"), "{messages}");
    let (model, _) = read("polynomial, n=2", &mooney_rivlin());
    for (value, i, j) in constants(&model) {
        let expected = if (i, j) == (1, 0) {
            C10
        } else if (i, j) == (0, 1) {
            C01
        } else {
            0.0
        };
        assert!((value - expected).abs() < 1e-8, "C{i}{j} = {value}");
    }
    assert_eq!(model.materials[0].hyperelastic.as_ref().expect("a law").compressibility, [0.0, 0.0]);
}

/// Uniaxial data do not determine a constant each of I1 and I2 well: a negative one makes equibiaxial tension unstable.
#[test]
fn unstable_fits_and_missing_data_are_reported() {
    let softening = "*Uniaxial Test Data\n 0.25, 0.1\n 0.9, 0.5\n 1.9, 1.0\n 5.6, 2.0\n";
    let (_, messages) = read("mooney-rivlin", softening);
    assert!(messages.contains("warning[M194]") && messages.contains("unstable in equibiaxial tension"), "{messages}");
    let (_, messages) = read("yeoh", "*Uniaxial Test Data\n 0.25, 0.1\n 0.9, 0.5\n");
    assert!(messages.contains("2 measured values do not determine 3 constants"), "{messages}");
    let (_, messages) = read("polynomial, n=1", "*Planar Test Data\n 0.25, 0.1\n 0.9, 0.5\n 1.2, 0.7\n");
    assert!(messages.contains("do not determine all constants"), "{messages}");
    let text = "*Material, name=M\n*Density\n 1.,\n*Hyperelastic, neo hooke\n 0.3, 0.\n*Uniaxial Test Data\n 1., 1.\n";
    let (deck, _) = deck::read_text("t.inp", text, &[]);
    let messages = model::build(&deck).1.render(&deck.sources);
    assert!(messages.contains("test data follow *HYPERELASTIC, TEST DATA INPUT"), "{messages}");
}

/// Nominal stresses of an Ogden energy `Σ 2 mu/alpha² (l1^alpha + l2^alpha + l3^alpha - 3)` in the three tests (Ogden 1972, Proc.
/// R. Soc. A 326, 565, with the moduli of ABAQUS): `Σ 2 mu/alpha (l^(alpha - 1) - l^(-k alpha - 1))`, k = 1/2, 2, 1.
fn ogden_stress(terms: &[[f64; 2]], ratio: f64, stretch: f64) -> f64 {
    let term =
        |[mu, alpha]: &[f64; 2]| 2.0 * mu / alpha * (stretch.powf(alpha - 1.0) - stretch.powf(-ratio * alpha - 1.0));
    terms.iter().map(term).sum()
}

const OGDEN_TESTS: [(&str, f64, &[f64]); 3] = [
    ("*Uniaxial Test Data", 0.5, &[0.6, 0.8, 1.02, 1.12, 1.24, 1.39, 1.9, 2.5, 3.2, 4.0, 5.2, 6.0, 6.8, 7.4]),
    ("*Biaxial Test Data", 2.0, &[1.02, 1.08, 1.14, 1.2, 1.42, 1.68, 1.94, 2.5, 3.0, 3.7, 4.4]),
    ("*Planar Test Data", 1.0, &[1.06, 1.21, 1.34, 1.6, 2.0, 2.6, 3.3, 4.2, 5.0]),
];

fn ogden_data(terms: &[[f64; 2]], tests: &[(&str, f64, &[f64])]) -> String {
    let mut cards = String::new();
    for (card, ratio, stretches) in tests {
        cards += &format!("{card}\n");
        for l in *stretches {
            cards += &format!(" {:.16e}, {:.16e}\n", ogden_stress(terms, *ratio, *l), l - 1.0);
        }
    }
    cards
}

fn ogden_constants(model: &Model) -> Vec<[f64; 2]> {
    let law = model.materials[0].hyperelastic.as_ref().expect("a law");
    let DeviatoricEnergy::Ogden(terms) = &law.shape else { panic!("an Ogden form") };
    terms.clone()
}

/// Data of known Ogden energies of one to three terms, among them those of Treloar's rubber (Ogden 1972: alpha 1.3, 5, -2; mu
/// 6.3, 0.012, -0.1 kg/cm² times alpha/2), give curves and constants of these energies, from all tests and from one.
#[test]
fn ogden_constants_are_those_of_the_data() {
    let treloar = [[0.1, -2.0], [4.095, 1.3], [0.03, 5.0]];
    for terms in [&treloar[..], &[[0.4, 2.0]], &[[0.03, -4.4], [0.35, 1.7]], &[[0.62, 1.3], [0.002, 6.5]]] {
        for tests in [&OGDEN_TESTS[..], &OGDEN_TESTS[..1], &OGDEN_TESTS[1..2]] {
            let form = format!("ogden, n={}", terms.len());
            let (model, messages) = read(&form, &ogden_data(terms, tests));
            assert!(!messages.contains("error[") && !messages.contains("warning["), "{messages}");
            let found = ogden_constants(&model);
            for (_, ratio, stretches) in tests {
                for l in *stretches {
                    let [fitted, expected] = [&found[..], terms].map(|t| ogden_stress(t, *ratio, *l));
                    assert!((fitted / expected - 1.0).abs() < 1e-6, "{l} {fitted} {expected}");
                }
            }
            if tests.len() == 3 {
                for (found, expected) in found.iter().zip(terms) {
                    assert!((0..2).all(|i| (found[i] / expected[i] - 1.0).abs() < 1e-4), "{found:?} {expected:?}");
                }
            }
        }
    }
}

/// Uniaxial tension of 8 % sulphur rubber by Treloar (1944, Trans. Faraday Soc. 40, 59), as often tabulated (stretch, nominal
/// stress in MPa): three terms describe it within a few per cent, and volumetric data give D1.
#[test]
fn treloar_rubber_is_fitted() {
    let data = [
        (1.02, 0.026),
        (1.12, 0.137),
        (1.24, 0.225),
        (1.39, 0.314),
        (1.61, 0.412),
        (1.89, 0.500),
        (2.17, 0.588),
        (2.42, 0.677),
        (3.01, 0.863),
        (3.58, 1.049),
        (4.03, 1.225),
        (4.76, 1.578),
        (5.36, 1.931),
        (5.75, 2.29),
        (6.15, 2.657),
        (6.4, 3.02),
        (6.6, 3.392),
        (6.85, 3.745),
        (7.05, 4.107),
        (7.15, 4.47),
        (7.25, 4.821),
        (7.4, 5.183),
        (7.5, 5.545),
        (7.6, 5.898),
        (7.7, 6.26),
    ];
    let rows: String = data.iter().map(|(l, t)| format!(" {t}, {}\n", l - 1.0)).collect();
    let cards = format!("*Uniaxial Test Data\n{rows}*Volumetric Test Data\n 20., 0.99\n 60., 0.97\n");
    let (model, messages) = read("ogden, n=3", &cards);
    assert!(messages.contains("fitted to 27 measured values: mu1 = "), "{messages}");
    let terms = ogden_constants(&model);
    let errors = data.map(|(l, t)| ogden_stress(&terms, 0.5, l) / t - 1.0);
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    // Two terms fit worse than three, one much worse.
    assert!(mean_square.sqrt() < 0.02, "{} {terms:?}", mean_square.sqrt());
    let law = model.materials[0].hyperelastic.as_ref().expect("a law");
    assert!((law.compressibility[0] / 1e-3 - 1.0).abs() < 0.2, "{:?}", law.compressibility);
}

/// Softening data give an unstable Ogden energy, which is reported with the strain.
#[test]
fn unstable_ogden_fits_are_reported() {
    let terms = [[-0.3, -1.0], [0.8, 2.0], [-0.004, 6.0]];
    let (_, messages) = read("ogden, n=3", &ogden_data(&terms, &OGDEN_TESTS[2..]));
    assert!(messages.contains("do not determine") || messages.contains("unstable in"), "{messages}");
    let soft = "*Uniaxial Test Data\n 0.2, 0.1\n 0.5, 0.3\n 0.7, 0.6\n 0.72, 0.9\n 0.6, 1.3\n 0.4, 1.8\n";
    let (_, messages) = read("ogden, n=2", soft);
    assert!(messages.contains("warning[M194]") && messages.contains("unstable in uniaxial tension"), "{messages}");
    let (_, messages) = read("ogden, n=2", "*Uniaxial Test Data\n 0.2, 0.1\n 0.5, 0.3\n 0.7, 0.6\n");
    assert!(messages.contains("3 measured values do not determine 4 constants"), "{messages}");
}
