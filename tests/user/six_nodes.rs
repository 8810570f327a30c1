//! User subroutines at the points of six-node triangles (CAX6M).
//!
//! Goal: in uniform strain all points of a CAX6M have the values of a CAX4R; subroutines receive the number of the
//! integration point and the nodes of the element; errors name both. Source: the same deck with quadrilaterals, and
//! closed forms of the geometry.

use std::sync::{Arc, Mutex};

use revolve::user::{
    FieldAnswer, FieldCall, LengthCall, LoadFailure, MaterialAnswer, MaterialCall, Routines, UserFields, UserLengths,
    UserMaterial,
};

use crate::common;
use crate::common::solid::in_six_node_triangles;
use crate::fields::{MODULI, with_field};
use crate::hardening::{FaultyHardening, LinearYieldStress, SOFT, SofteningField, pulled};
use crate::material::{KEEPING, StrainRecorder};

/// State variables, their initial values and names, fields, `vgetvrm` (stress, strain, plastic strain), deletion by a
/// state variable. All columns of a run in uniform strain equal those of quadrilaterals.
#[test]
fn uniform_strain_gives_the_columns_of_quadrilaterals() {
    let outputs = " S, PEEQ, LE22, SDV, STATUS\n*Energy Output\n ALLIE, ALLPD, ALLSE, ALLDMD\n";
    let user = |cards: &str| pulled(cards, " S, SDV, STATUS\n*Energy Output\n ALLIE, ALLPD\n");
    let start = "*Depvar, delete=4\n 9,\n*Initial Conditions, type=SOLUTION\n SOLID, 0.5, 2., , 1., , ,7.\n 8., 9.\n";
    let softening = |limit| Routines::none().with_fields(SofteningField { limit });
    let flows = |limit| softening(limit).with_hardening(LinearYieldStress { slopes: true });
    let fields = "*User Defined Field, properties=1\n 0.8,\n";
    let built_in = "*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 15., 1.\n";
    let moduli = with_field(&pulled(MODULI, " S, LE22\n"), "*Field, variable=1, amplitude=RISE\n ALL, 1.\n");
    for (name, deck, routines) in [
        ("vumat", user(KEEPING), Routines::none().with_material(StrainRecorder { limit: f64::INFINITY })),
        ("vumat, deletion", user(KEEPING), Routines::none().with_material(StrainRecorder { limit: 0.2 })),
        ("vuhard", pulled(&format!("{SOFT}{fields}{start}"), outputs), flows(f64::INFINITY)),
        ("vuhard, deletion", pulled(&format!("{SOFT}{fields}{start}"), outputs), flows(0.1)),
        ("vusdfld", pulled(&format!("{built_in}{fields}{start}"), outputs), softening(0.1)),
        ("*FIELD", moduli, Routines::none()),
    ] {
        let triangles = in_six_node_triangles(&deck, [2, 2]);
        let [(quads, expected), (outcome, got)] = [&deck, &triangles].map(|text| common::run(text, &[], &routines));
        assert_eq!((&quads.halt, &outcome.halt), (&None, &None), "{name}");
        let names = common::prepared(&triangles, &[], &routines).plan.columns;
        let mut worst: f64 = 0.0;
        for ((time, a), (_, b)) in expected.rows.iter().zip(&got.rows) {
            for (column, (a, b)) in names.iter().zip(a.iter().zip(b)) {
                // The last arguments that the recorder stores are density and length.
                if column.name == "SDV15@ONE" {
                    continue;
                }
                let apart = (a - b).abs() / a.abs().max(1.0);
                worst = worst.max(apart);
                assert!(apart < 1e-9, "{name}, {time}: {} {a} {b}", column.name);
            }
        }
        println!("{name}: {} columns, largest relative difference {worst:.1e}", names.len());
    }
}

/// Calls of a subroutine: integration point, and element numbers.
pub type CallLog = Arc<Mutex<Vec<(usize, Vec<i32>)>>>;

/// Three times the default length; stores the calls, and checks the nodes of the elements.
#[derive(Default)]
pub struct TripledLength(pub CallLog);

impl UserLengths for TripledLength {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        let n = call.count;
        self.0.lock().expect("a log").push((call.integration_point, call.elements.to_vec()));
        assert!(call.corners == 6 && call.nodes.len() == 12 * n);
        for i in 0..n {
            let node = |k: usize| [call.nodes[k * n + i], call.nodes[(6 + k) * n + i]];
            let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            for k in 0..3 {
                assert_eq!(node(3 + k), middle(node(k), node((k + 1) % 3)));
            }
            // The point has the weights 2/3, 1/6 and 1/6 of the corners.
            for axis in 0..2 {
                let weight = |k: usize| if k + 1 == call.integration_point { 4.0 } else { 1.0 };
                let place: f64 = (0..3).map(|k| weight(k) / 6.0 * node(k)[axis]).sum();
                assert!((call.coordinates[axis * n + i] - place).abs() < 1e-12, "{place}");
            }
        }
        lengths.iter_mut().for_each(|l| *l *= 3.0);
        Ok(())
    }
}

/// User fields that store the length they receive, and the number of the integration point.
struct PointLog;

impl UserFields for PointLog {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        answer.state[..call.count].copy_from_slice(call.length);
        answer.state[call.count..2 * call.count].fill(call.integration_point as f64);
        Ok(())
    }
}

/// The default length is half the square root of the area of the element, which grows from 2 to 4. The mean of the numbers
/// of the points is weighted by their volumes, which are proportional to their radii 5/3, 8/3 and 8/3.
#[test]
fn subroutines_receive_points_and_nodes() {
    let log = CallLog::default();
    let cards = "*Elastic\n 1000., 0.3\n*User Defined Field\n*Depvar\n 2,\n*Characteristic Length, definition=USER\n";
    let text = in_six_node_triangles(&pulled(cards, " SDV1, SDV2\n"), [2, 2]);
    let routines = Routines::none().with_fields(PointLog).with_lengths(TripledLength(Arc::clone(&log)));
    let (outcome, memory) = common::run(&text, &[], &routines);
    assert_eq!(outcome.halt, None);
    let row = &memory.rows.last().expect("a row").1;
    assert!((row[0] - 3.0).abs() < 3e-3 && (row[1] - 15.0 / 7.0).abs() < 1e-12, "{row:?}");
    let calls = log.lock().expect("a log");
    assert_eq!(calls.len() as u64, 3 * outcome.increments);
    for (i, call) in calls.iter().enumerate() {
        assert_eq!(*call, (i % 3 + 1, vec![1, 2]));
    }
}

/// A liquid: its response has no shear stress.
struct Liquid;

impl UserMaterial for Liquid {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        for i in 0..n {
            let dilation = call.strain[i] + call.strain[n + i] + call.strain[2 * n + i];
            for k in 0..4 {
                answer.stress[k * n + i] = call.stress[k * n + i] + if k < 3 { 1000.0 * dilation } else { 0.0 };
            }
        }
        Ok(())
    }
}

#[test]
fn halts_name_element_and_point() {
    let hardening = in_six_node_triangles(&pulled(&format!("{SOFT}*Depvar\n 1,\n"), " S22\n"), [2, 2]);
    let liquid = in_six_node_triangles(&pulled("*User Material, constants=1\n 0.,\n", " S22\n"), [2, 2]);
    for (deck, routines, words) in [
        (&hardening, Routines::none().with_hardening(FaultyHardening("own")), "element 2, integration point 1"),
        (&liquid, Routines::none().with_material(Liquid), "no shear modulus, which six-node triangles need"),
    ] {
        let halt = common::run(deck, &[], &routines).0.halt.expect("a halt");
        assert!(halt.message().contains(words), "{halt:?}");
    }
}
