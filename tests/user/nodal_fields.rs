//! Field variables at nodes by a user subroutine (`*FIELD, USER`, VUFIELD).
//!
//! Goal: the subroutine receives nodes, times, coordinates and motion of the manual; its fields reach the tables of the
//! elements as those of `*FIELD` do, one or several together, over steps; failures name the node. Needs gfortran for
//! Fortran files; without it these tests are left out, except in CI.

use revolve::job;
use revolve::user::{LoadFailure, NodalFieldCall, Routines, UserNodalFields};

use crate::common::{self, RecordedOutput};
use crate::fields::{MODULI, with_field};
use crate::material::{compiled, moving};

fn stretched(material: &str, outputs: &str) -> String {
    moving(|[_, z]| [0.0, z], material, outputs)
}

/// Returns the rows of a run.
fn rows(text: &str, routines: &Routines) -> Vec<Vec<f64>> {
    let (outcome, memory): (_, RecordedOutput) = common::run(text, &[], routines);
    assert_eq!(outcome.halt, None);
    memory.rows.iter().map(|row| row.1.clone()).collect()
}

#[track_caller]
fn assert_same(found: &[Vec<f64>], expected: &[Vec<f64>], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} {b}");
    }
}

/// The two variables of this subroutine are the total time, and twice the time in the step plus its duration less 1.
const TIMES: &str = "
      subroutine vufield(field, nblock, nfield, kfield, ncomp, kstep, jflags, jnodeuid, time, coords, u, v, a)
      include 'vaba_param.inc'
      dimension field(nblock,ncomp,nfield), jflags(2), jnodeuid(nblock), time(4), coords(3,nblock)
      dimension u(8,nblock), v(8,nblock), a(8,nblock)
      do k = 1, nblock
        do i = 1, nfield
          if (kfield + i - 1 .eq. 1) field(k,1,i) = time(4)
          if (kfield + i - 1 .eq. 2) field(k,1,i) = 2*time(1) + (time(3) - 1)
        end do
      end do
      end
";

/// A field of the subroutine that is the time acts as the field of `*FIELD` with an amplitude; two variables set together act
/// as two fields, with blocks, without and with a process of their own.
#[test]
fn user_fields_act_as_given_fields() {
    if !common::fortran("vufield in Fortran") {
        return;
    }
    let routines = compiled(TIMES).expect("it compiles");
    let plain = stretched(MODULI, " S, LE22\n").replace("number interval=10", "frequency=1");
    let given = rows(&with_field(&plain, "*Field, variable=1, amplitude=RISE\n ALL, 1.\n"), &Routines::none());
    assert_same(&rows(&with_field(&plain, "*Field, variable=1, user\n ALL,\n"), &routines), &given, 1e-10);
    let table = "*Elastic, dependencies=2\n 1000., 0.3, , 0., 0.\n 400., 0.2, , 1., 0.\n 500., 0.1, , 0., 2.\n 200., 0., , 1., 2.\n";
    let plain = stretched(table, " S, LE22\n").replace("number interval=10", "frequency=1");
    let both = "*Field, variable=1, amplitude=RISE\n ALL, 1.\n*Field, variable=2, amplitude=RISE\n ALL, 2.\n";
    let given = rows(&with_field(&plain, both), &Routines::none());
    for cards in ["*Field, user, number=2\n ALL,\n", "*Field, user, variable=2\n ALL,\n*Field, user\n ALL\n"] {
        assert_same(&rows(&with_field(&plain, cards), &routines), &given, 1e-10);
    }
    // A field of the deck that is given later replaces that of the subroutine.
    let mixed = "*Field, user, number=2\n ALL,\n*Field, variable=2, amplitude=RISE\n ALL, 2.\n";
    let replaced = rows(&with_field(&plain, mixed), &routines);
    assert!(replaced.iter().flatten().all(|value| value.is_finite()));
}

/// A Rust subroutine that checks its arguments, and sets the axial displacement.
struct Displacement;

impl UserNodalFields for Displacement {
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure> {
        assert_eq!((call.set, call.variables), ("ALL", [1, 1]));
        assert!(values.iter().all(|value| *value == 0.25), "initial values");
        let [u, v, _] = call.motion;
        for (k, value) in values.iter_mut().enumerate() {
            let (z, time) = (call.coordinates[3 * k + 1], call.now.total_time);
            // Nodes move with a velocity equal to their initial height.
            let height = z - u[8 * k + 1];
            assert!(
                (u[8 * k + 1] - height * time).abs() < 1e-9 && u[8 * k] == 0.0 && call.coordinates[3 * k + 2] == 0.0
            );
            // The velocity is extrapolated from the middle of the increment; the motion begins at rest.
            assert!(time < 2e-3 || (v[8 * k + 1] - height).abs() < 1e-9, "{} {height}", v[8 * k + 1]);
            *value = u[8 * k + 1];
        }
        assert!(call.lengths[1] == 1.0 && call.nodes.iter().all(|number| *number > 0));
        Ok(())
    }
}

/// Moduli that depend on the displacement of the nodes: each element has the mean of its nodes, here the time times the mean
/// height, in every increment.
#[test]
fn fields_may_depend_on_the_motion_of_nodes() {
    let text = stretched("*Elastic, dependencies=1\n 1000., 0., , 0.\n 3000., 0., , 2.\n", " S22, LE22\n");
    let text = with_field(&text, "*Field, user\n ALL,\n");
    let text = text.replace("*Step\n", "*Initial Conditions, type=FIELD, variable=1\n ALL, 0.25\n*Step\n");
    let routines = Routines::none().with_nodal_fields(Displacement);
    let prepared = common::prepared(&text, &[], &routines);
    let at = |name: &str| prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    let (stress, strain) = (at("S22@ONE"), at("LE22@ONE"));
    let (outcome, memory) = common::run(&text, &[], &routines);
    assert_eq!(outcome.halt, None);
    for (time, row) in memory.rows.iter().skip(1) {
        let modulus = row[stress] / row[strain];
        let height = (modulus - 1000.0) / (1000.0 * time);
        // One of the heights of the centres of the elements of a tube of length 1 or 2.
        assert!(height > 0.1 && (4.0 * height - (4.0 * height).round()).abs() < 1e-6, "{height}");
    }
}

struct Broken;

impl UserNodalFields for Broken {
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure> {
        if call.now.total_time > 0.5 {
            values[0] = f64::NAN;
        }
        Ok(())
    }
}

#[test]
fn failures_of_user_fields_are_reported() {
    let text = with_field(&stretched(MODULI, " S\n"), "*Field, user\n ALL,\n");
    let (outcome, _) = common::run(&text, &[], &Routines::none().with_nodal_fields(Broken));
    let halt = outcome.halt.expect("it halts").to_string();
    assert!(
        halt.contains("vufield of `ALL`") && halt.contains("set variable 1 of node") && halt.contains("NaN"),
        "{halt}"
    );
    let messages = |text: &str| {
        let prepared = job::prepare_text("test.inp", text, &[], &Routines::none());
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    assert!(messages(&text).contains("vufield"), "{}", messages(&text));
    for (card, expected) in [
        ("*Field, number=2\n ALL, 1.\n", "require USER"),
        ("*Field, user, amplitude=RISE\n ALL,\n", "remove AMPLITUDE"),
        ("*Field, user, variable=100, number=2\n ALL,\n", "would be 101"),
    ] {
        let found = messages(&with_field(&stretched(MODULI, " S\n"), card));
        assert!(found.contains(expected), "{found}");
    }
}
