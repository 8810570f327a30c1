//! Material laws in Rust (`MaterialLaw`) compared with the built-in law and closed forms.
//!
//! Goal: such a law supports all that a built-in law supports: results, threads, deletion, restart, located messages.

use revolve::job;
use revolve::user::{ElasticModuli, LoadFailure, MaterialLaw, MaterialPoint, Routines};

use crate::common;
use crate::common::solid::{copper_bar, in_six_node_triangles};
use crate::material::{last, moving, taylor};

/// Linear hardening with Young's modulus, Poisson's ratio, yield stress and slope. State variable 1 is the plastic
/// strain; the second becomes 0 beyond a plastic strain.
struct LinearHardeningLaw {
    limit: f64,
}

impl MaterialLaw for LinearHardeningLaw {
    fn moduli(&self, constants: &[f64]) -> Result<ElasticModuli, LoadFailure> {
        let &[young, ratio, _, _] = constants else {
            return Err(LoadFailure::new("constants: E, nu, yield stress, slope"));
        };
        Ok(ElasticModuli::from_young(young, ratio))
    }

    fn state_variables(&self) -> usize {
        1
    }

    fn update(&self, point: &mut MaterialPoint<'_>) {
        let &[young, ratio, yields, slope] = point.constants else { unreachable!("four constants") };
        let ElasticModuli { bulk, shear } = ElasticModuli::from_young(young, ratio);
        let third = |t: [f64; 4]| (t[0] + t[1] + t[2]) / 3.0;
        let volumetric = |i: usize, value: f64| if i < 3 { value } else { 0.0 };
        let (old, strain) = (point.stress, point.strain);
        let mean = third(old) + 3.0 * bulk * third(strain);
        let trial = [0, 1, 2, 3]
            .map(|i| old[i] - volumetric(i, third(old)) + 2.0 * shear * (strain[i] - volumetric(i, third(strain))));
        let [a, b, c, d] = trial.map(|s| s * s);
        let mises = (1.5 * (a + b + c) + 3.0 * d).sqrt();
        let excess = mises - (yields + slope * point.state[0]);
        let flow = if excess > 0.0 { excess / (3.0 * shear + slope) } else { 0.0 };
        let factor = if flow > 0.0 { 1.0 - 3.0 * shear * flow / mises } else { 1.0 };
        point.stress = [0, 1, 2, 3].map(|i| factor * trial[i] + volumetric(i, mean));
        point.state[0] += flow;
        if flow > 0.0 {
            // The work of the mean of previous and new stress; the plastic strain increment is 3/2 flow trial/mises.
            let part = |i: usize| (old[i] + point.stress[i]) * trial[i];
            point.dissipated = 0.75 * flow / mises * (part(0) + part(1) + part(2) + 2.0 * part(3));
        }
        if point.state[0] > self.limit {
            point.state[1] = 0.0;
        }
    }
}

const BUILT_IN: &str = "*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 900.e6, 5.\n";
const BY_LAW: &str = "*User Material, constants=4\n 117.e9, 0.35, 400.e6, 100.e6\n*Depvar\n 1,\n";

fn routines(limit: f64) -> Routines {
    Routines::none().with_law("Copper", LinearHardeningLaw { limit }).with_law("M", LinearHardeningLaw { limit })
}

#[test]
fn taylor_bar_of_a_law_in_rust_matches_built_in_law() {
    let (built_in, by_law) = (taylor(BUILT_IN, "PEEQ"), taylor(BY_LAW, "SDV1"));
    let (expected, there) = common::run(&built_in, &[], &Routines::none());
    let (got, here) = common::run(&by_law, &[], &routines(f64::INFINITY));
    assert_eq!((got.halt, got.increments), (None, expected.increments));
    let same = ["U1@CORNER", "U2@TIP", "ALLIE", "ALLPD", "ALLSE", "S22@FOOT"].map(|name| (name, name));
    for (one, other) in same.into_iter().chain([("PEEQ@FOOT", "SDV1@FOOT")]) {
        let expected = last(&built_in, &Routines::none(), &there, one);
        let ratio = last(&by_law, &routines(f64::INFINITY), &here, other) / expected;
        // The same law with sums in another order; plastic flow amplifies rounding over 1000 increments.
        assert!((ratio - 1.0).abs() < 1e-9, "{one}: {expected:e}, ratio {ratio:.15}");
    }
}

#[test]
fn six_node_triangles_of_a_law_match_those_of_the_built_in_law() {
    let built_in = in_six_node_triangles(&copper_bar([4, 20], false, |place| place), [4, 20]);
    // Rounding decides when the global estimate is renewed.
    let built_in = built_in.replace("*Dynamic, Explicit", "*Dynamic, Explicit, element by element");
    assert!(built_in.contains("element by element"), "{built_in}");
    let cards = "*Elastic\n 1.17e5, 0.35\n*Plastic\n 400., 0.\n 500., 1.\n 700., 3.\n";
    assert!(built_in.contains(cards), "{built_in}");
    let by_law = built_in.replace(cards, "*User Material, constants=4\n 1.17e5, 0.35, 400., 100.\n*Depvar\n 1,\n");
    let (expected, there) = common::run(&built_in, &[], &Routines::none());
    let (got, here) = common::run(&by_law, &[], &routines(f64::INFINITY));
    assert_eq!((got.halt, got.increments), (None, expected.increments));
    for name in ["COOR2@TIP", "COOR1@RIM"] {
        let expected = last(&built_in, &Routines::none(), &there, name);
        let ratio = last(&by_law, &routines(f64::INFINITY), &here, name) / expected;
        // As for quadrilaterals: the same law with sums in another order.
        assert!((ratio - 1.0).abs() < 1e-9, "{name}: {expected:e}, ratio {ratio:.15}");
    }
}

#[test]
fn state_variable_of_depvar_deletes_elements() {
    let material = "*User Material, constants=4\n 1000., 0.3, 10., 5.\n*Depvar, delete=2\n 2,\n";
    let deck = moving(|[_, z]| [0.0, z], material, " S22, SDV1, STATUS\n");
    let (outcome, memory) = common::run(&deck, &[], &routines(0.1));
    assert_eq!(outcome.halt, None);
    let column = |name: &str| {
        let prepared = common::prepared(&deck, &[], &routines(0.1));
        let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
        memory.rows.iter().map(|row| row.1[at]).collect::<Vec<f64>>()
    };
    let (status, stress) = (column("STATUS@ONE"), column("S22@ONE"));
    let gone = status.iter().position(|s| *s == 0.0).expect("it is deleted");
    assert!(gone > 1 && stress[gone - 1] > 10.0 && stress[gone..].iter().all(|s| *s == 0.0), "{stress:?}");
    assert!(column("SDV1@ONE")[gone] > 0.1);
}

#[test]
fn constants_and_state_variables_are_checked_with_a_place() {
    for (material, words) in [
        ("*User Material, constants=1\n 1.\n*Depvar\n 1,\n", "constants: E, nu, yield stress, slope"),
        ("*User Material, constants=4\n 1., 0.3, 1., 1.\n", "needs 1 state variables, but *DEPVAR gives 0"),
    ] {
        let prepared = job::prepare_text("test.inp", &taylor(material, "S"), &[], &routines(1.0));
        let rendered = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(rendered.contains("P041") && rendered.contains(words) && rendered.contains("test.inp:"), "{rendered}");
    }
}
