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
    let (_, messages) = read("ogden", softening);
    assert!(messages.contains("polynomial forms only"), "{messages}");
    let text = "*Material, name=M\n*Density\n 1.,\n*Hyperelastic, neo hooke\n 0.3, 0.\n*Uniaxial Test Data\n 1., 1.\n";
    let (deck, _) = deck::read_text("t.inp", text, &[]);
    let messages = model::build(&deck).1.render(&deck.sources);
    assert!(messages.contains("test data follow *HYPERELASTIC, TEST DATA INPUT"), "{messages}");
}
