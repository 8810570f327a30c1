//! Field variables in tables (`DEPENDENCIES=`, `*FIELD`, VUSDFLD), user-defined characteristic lengths (VUCHARLENGTH),
//! and amplitudes that depend on sensors on deformable bodies (VUAMP), compared with closed forms.
//!
//! Goal: prescribed nodal fields reach the tables of the elements, and the same field from a user subroutine gives the
//! same values; damage with twice the characteristic length dissipates the energy of the closed form; an amplitude
//! stops a wave at the value of its sensor. Needs gfortran for Fortran files; without it those tests are left out,
//! except in CI.

use revolve::user::{FieldAnswer, FieldCall, LengthCall, LoadFailure, Routines, UserFields, UserLengths};

use crate::common::solid::{grid, in_six_node_triangles};
use crate::common::{self, RecordedOutput};
use crate::material::{compiled, moving};
use crate::six_nodes::TripledLength;

/// Returns the values of a column.
fn column(text: &str, routines: &Routines, memory: &RecordedOutput, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).unwrap_or_else(|| panic!("no column {name}"));
    memory.rows.iter().map(|row| row.1[at]).collect()
}

/// Returns a tube of 2 by 2 elements stretched along z at a rate of one length per time, without radial motion.
fn stretched(material: &str, outputs: &str) -> String {
    moving(|[_, z]| [0.0, z], material, outputs)
}

/// Adds a field equal to the time at the given nodes.
pub fn with_field(text: &str, cards: &str) -> String {
    text.replace("*Step\n", "*Amplitude, name=RISE\n 0., 0., 1., 1.\n*Step\n")
        .replace("*Output, history", &format!("{cards}*Output, history"))
}

pub const MODULI: &str = "*Elastic, dependencies=1\n 1000., 0.3, , 0.\n 400., 0.2, , 0.5\n 800., 0.1, , 1.\n";
/// Returns the modulus of uniaxial strain from Young's modulus and Poisson's ratio of the table, linear between its
/// rows.
fn oedometric(field: f64) -> f64 {
    let (e, nu) =
        if field < 0.5 { (1000.0 - 1200.0 * field, 0.3 - 0.2 * field) } else { (800.0 * field, 0.3 - 0.2 * field) };
    e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
}

/// User field equal to the total time at all points.
struct TimeField;

impl UserFields for TimeField {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        answer.field[..call.count].fill(call.now.total_time);
        Ok(())
    }
}

const TIME_IN_FORTRAN: &str = "
subroutine vusdfld(nblock, nstatev, nfieldv, nprops, ndir, nshr, jElem, kIntPt, kLayer, kSecPt, stepTime, totalTime, dt, &
    cmname, coordMp, direct, T, charLength, props, stateOld, stateNew, field)
  include 'vaba_param.inc'
  dimension jElem(nblock), coordMp(nblock,*), direct(nblock,3,3), T(nblock,3,3), charLength(nblock), props(nprops), &
    stateOld(nblock,nstatev), stateNew(nblock,nstatev), field(nblock,nfieldv)
  character*80 cmname
  do k = 1, nblock
    field(k,1) = totalTime
  end do
end subroutine
";

/// Uniaxial strain: the stress is E(f) (1 - nu(f)) / ((1 + nu(f)) (1 - 2 nu(f))) times the total strain, in every
/// increment, for a field from `*FIELD`, from Rust and from Fortran.
#[test]
fn field_dependent_moduli_scale_the_total_elastic_strain() {
    let outputs = " S, LE22\n";
    let plain = stretched(MODULI, outputs).replace("number interval=10", "frequency=1");
    let by_history = with_field(&plain, "*Field, variable=1, amplitude=RISE\n ALL, 1.\n");
    let by_routine = plain.replace("*Density", "*User Defined Field\n*Density");
    let (_, memory) = common::run(&by_history, &[], &Routines::none());
    let rows = |name: &str| column(&by_history, &Routines::none(), &memory, &format!("{name}@ONE"));
    let (stress, strain) = (rows("S22"), rows("LE22"));
    assert!(strain.last().is_some_and(|e| (e - 2f64.ln()).abs() < 1e-6), "the final length is twice the initial one");
    let mut worst: f64 = 0.0;
    for ((time, _), (s, e)) in memory.rows.iter().zip(stress.iter().zip(&strain)).skip(1) {
        worst = worst.max((s / (oedometric(*time) * e) - 1.0).abs());
    }
    // Rounding of 1000 increments.
    assert!(worst < 1e-11, "{worst:e}");
    let mut routines = vec![Routines::none().with_fields(TimeField)];
    if common::fortran("fields of the user in Fortran") {
        routines.push(compiled(TIME_IN_FORTRAN).expect("it compiles"));
    }
    for routines in routines {
        let (outcome, memory) = common::run(&by_routine, &[], &routines);
        assert_eq!(outcome.halt, None);
        for name in ["S11", "S22", "S33"] {
            let got = column(&by_routine, &routines, &memory, &format!("{name}@ONE"));
            let far = got.iter().zip(rows(name)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The time of the amplitude equals that of the user subroutine, except for rounding.
            assert!(far < 1e-10, "{name}: {far:e}");
        }
    }
}

/// A subroutine that sets a second field variable where the model has one; gfortran cannot check `(nblock,*)`.
#[test]
fn a_field_variable_that_does_not_exist_is_named() {
    if !common::fortran("a field variable that does not exist") {
        return;
    }
    let source =
        TIME_IN_FORTRAN.replace("field(nblock,nfieldv)", "field(nblock,*)").replace("field(k,1)", "field(k,2)");
    let deck = stretched(MODULI, " S\n").replace("*Density", "*User Defined Field\n*Density");
    let (outcome, _) = common::run(&deck, &[], &compiled(&source).expect("it compiles"));
    let halt = outcome.halt.expect("a halt");
    let message = halt.message();
    assert!(message.contains("at field(1,2); the model has nfieldv = 1 field variables"), "{message}");
}

/// Yield stress as a function of plastic strain and two fields, the first of which increases with time: (10 + 5 p)(1 -
/// f1) + (4 + 2 p) f1, times a factor from the second; checked in every plastic increment.
#[test]
fn field_dependent_yield_stress_matches_the_table() {
    let table = |factor: f64, second: f64| {
        format!(
            " {}, 0., , 0., {second}\n {}, 1., , 0., {second}\n {}, 0., , 1., {second}\n {}, 1., , 1., {second}\n",
            10.0 * factor,
            15.0 * factor,
            4.0 * factor,
            6.0 * factor
        )
    };
    let plastic = format!("*Elastic\n 1000., 0.3\n*Plastic, dependencies=2\n{}{}", table(1.0, 0.0), table(3.0, 2.0));
    let text = stretched(&plastic, " MISES, PEEQ, PE\n").replace("number interval=10", "frequency=1");
    let start = "*Initial Conditions, type=FIELD, variable=2\n ALL, 0.5\n*Step\n";
    let by_history = with_field(&text.replace("*Step\n", start), "*Field, amplitude=RISE\n ALL, 1.\n");
    let by_routine = text.replace("*Step\n", start).replace("*Density", "*User Defined Field\n*Density");
    let routines = Routines::none().with_fields(TimeField);
    for (text, routines) in [(&by_history, &Routines::none()), (&by_routine, &routines)] {
        let (outcome, memory) = common::run(text, &[], routines);
        assert_eq!(outcome.halt, None);
        let rows = |name: &str| column(text, routines, &memory, &format!("{name}@ONE"));
        let (mises, strain, axial) = (rows("MISES"), rows("PEEQ"), rows("PE22"));
        let flows = strain.iter().position(|p| *p > 0.0).expect("it yields");
        assert!(flows < 30 && strain.last().is_some_and(|p| *p > 0.4), "{flows} {:?}", strain.last());
        for i in flows..strain.len() {
            let (f, p) = (memory.rows[i].0, strain[i]);
            // 0.5 is a quarter of the way from factor 1 to factor 3.
            let expected = 1.5 * ((1.0 - f) * (10.0 + 5.0 * p) + f * (4.0 + 2.0 * p));
            assert!((mises[i] / expected - 1.0).abs() < 1e-10, "{f}: {} {expected}", mises[i]);
            // Isochoric plastic flow along z: the equivalent plastic strain is the axial one.
            assert!((axial[i] - p).abs() < 1e-10, "{} {p}", axial[i]);
        }
    }
}

/// Elements use the mean of their nodes; a field keeps its value over the steps until OP=NEW, after which fields
/// without a definition return to their initial value.
#[test]
fn element_fields_average_nodal_fields_over_steps() {
    let moduli = "*Elastic, dependencies=1\n 100., 0., , 0.\n 1100., 0., , 1.\n";
    let text = stretched(moduli, " S22, LE22\n").replace("1.e-3, 1.", "1.e-3, 0.1");
    let text = text.replace("*Step\n", "*Elset, elset=TWO\n 3,\n*Amplitude, name=RISE\n 0., 0., 0.1, 1.\n*Step\n");
    let text = text.replace("*End Step\n", "*Element Output, elset=TWO\n S22, LE22\n*End Step\n");
    // The upper row of elements has two nodes on the middle line and two on the top line.
    let start = "*Initial Conditions, type=FIELD\n J0, 0.2\n J1, 0.4\n*Step\n";
    let text = text.replace("*Step\n", start);
    let first = text.replace("*Output", "*Field, amplitude=RISE\n J1, 0.8\n*Output");
    let step = |cards: &str| format!("*Step\n*Dynamic, Explicit, direct user control\n 1.e-3, 0.1\n{cards}*End Step\n");
    let deck = first + &step("") + &step("*Field, op=NEW\n J0, 0.6\n");
    let (outcome, memory) = common::run(&deck, &[], &Routines::none());
    assert_eq!(outcome.halt, None);
    let modulus = |set: &str, end: f64| {
        let i = memory.rows.iter().rposition(|r| (r.0 - end).abs() < 1e-9).expect("a row");
        let of = |name: &str| column(&deck, &Routines::none(), &memory, &format!("{name}@{set}"))[i];
        of("S22") / of("LE22")
    };
    // Modulus 100 + 1000 f, where f is the mean of two nodes of each line.
    for (end, low, high) in [(0.1, 0.5 * 0.2, 0.5 * 0.8), (0.2, 0.5 * 0.2, 0.5 * 0.8), (0.3, 0.5 * 0.6, 0.5 * 0.4)] {
        for (set, f) in [("ONE", low), ("TWO", high)] {
            let expected = 100.0 + 1000.0 * f;
            assert!(
                (modulus(set, end) / expected - 1.0).abs() < 1e-10,
                "{set} {end}: {} {expected}",
                modulus(set, end)
            );
        }
    }
}

/// Two rows of moduli over the temperature: halfway between them the mean moduli.
#[test]
fn temperature_dependent_moduli_are_linear_between_rows() {
    let start = "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Step\n";
    let stress = |moduli: &str| {
        let text = stretched(&format!("*Elastic\n{moduli}"), " S22\n").replace("*Step\n", start);
        let (outcome, memory) = common::run(&text, &[], &Routines::none());
        assert_eq!(outcome.halt, None);
        column(&text, &Routines::none(), &memory, "S22@ONE").pop().expect("a row")
    };
    let ratio = stress(" 1000., 0.2, 10.\n 2000., 0.3, 30.\n") / stress(" 1500., 0.25\n");
    // The same increments summed in two ways.
    assert!((ratio - 1.0).abs() < 1e-11, "{ratio}");
}

/// Fields without dependent properties have no effect and leave the bits unchanged.
#[test]
fn unused_fields_are_reported_and_change_nothing() {
    let plain = stretched("*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 15., 1.\n", " S\n");
    let other = with_field(&plain, "*Field, amplitude=RISE\n ALL, 1.\n");
    let (prepared, without) =
        (common::prepared(&other, &[], &Routines::none()), common::prepared(&plain, &[], &Routines::none()));
    assert!(prepared.plan.ledger.unused.iter().any(|u| u.what.contains("*FIELD")));
    assert!(prepared.plan.ledger.effects.iter().all(|e| e.effect != "predefined fields"));
    let bytes =
        |p: &revolve::job::PreparedJob| p.plan.ledger.effects.iter().map(|e| e.arrays.clone()).collect::<Vec<_>>();
    assert_eq!(bytes(&prepared), bytes(&without));
    let digest = |text: &str| common::run(text, &[], &Routines::none()).0.digest;
    assert_eq!(digest(&other), digest(&plain));
}

pub const TWICE: &str = "
subroutine vucharlength(nblock, nfieldv, nprops, ncomp, ndim, nnode, nstatev, kSecPt, kLayer, kIntPt, jElType, jElem, &
    totalTime, stepTime, dt, cmname, coordMp, coordNode, direct, T, props, field, stateOld, charLength)
  include 'vaba_param.inc'
  dimension jElType(3), jElem(nblock), coordMp(nblock,ndim), coordNode(nblock,nnode,ndim), direct(nblock,3,3), &
    T(nblock,3,3), props(nprops), stateOld(nblock,nstatev), charLength(nblock,ncomp), field(nblock,nfieldv)
  character*80 cmname
  do k = 1, nblock
    a = 0.5d0*((coordNode(k,3,1) - coordNode(k,1,1))*(coordNode(k,4,2) - coordNode(k,2,2)) &
      - (coordNode(k,4,1) - coordNode(k,2,1))*(coordNode(k,3,2) - coordNode(k,1,2)))
    rmid = 0.25d0*sum(coordNode(k,:,1))
    if (abs(sqrt(a) - charLength(k,1)) .gt. 1.d-12 .or. abs(rmid - coordMp(k,1)) .gt. 1.d-12) call xplb_exit
    if (jElType(1) .ne. 3 .or. nnode .ne. 4 .or. cmname .ne. 'M') call xplb_exit
    charLength(k,1) = props(1)*charLength(k,1)
  end do
end subroutine
";

/// Returns a deck of simple shear to complete damage over a plastic displacement, with an additional card of the
/// material.
pub fn sheared(card: &str) -> String {
    let damage = "*Elastic\n 26000., 0.3\n*Plastic\n 10., 0.\n*Damage Initiation, criterion=JOHNSON COOK\n \
                  0.1, 0., 0., 0., 0., 0., 0., 1.\n*Damage Evolution, type=DISPLACEMENT\n 0.2,\n";
    let outputs = " PEEQ, SDEG, STATUS\n*Energy Output\n ALLPD, ALLDMD\n";
    moving(|[r, _]| [0.0, r], &format!("{damage}{card}"), outputs)
        .replace("number interval=10", "frequency=1")
        .replace("1.e-3, 1.", "1.e-4, 1.")
}

/// Simple shear g at constant volume V: dp = dg / sqrt 3. Damage starts at the plastic strain p0 and is linear over a
/// plastic displacement, so that the element is deleted at p0 + u_f / L, and the dissipated energy is V Y (p0 + u_f / 2
/// L) plus the elastic energy V Y^2 / 6 G.
#[test]
fn doubled_characteristic_length_halves_the_damage_strain() {
    if !common::fortran("characteristic lengths of the user in Fortran") {
        return;
    }
    let twice = sheared("*Characteristic Length, definition=USER, properties=1\n 2.,\n");
    let routines = compiled(TWICE).expect("it compiles");
    let (once, none) = (sheared(""), Routines::none());
    let [six_once, six_twice] = [&once, &twice].map(|deck| in_six_node_triangles(deck, [2, 2]));
    // Triangles of the area 2: half the root of the area.
    let (half, tripled) = (0.5_f64.sqrt(), Routines::none().with_lengths(TripledLength::default()));
    for (text, routines, length) in
        [(&once, &none, 1.0), (&twice, &routines, 2.0), (&six_once, &none, half), (&six_twice, &tripled, 3.0 * half)]
    {
        let (outcome, memory) = common::run(text, &[], routines);
        assert_eq!(outcome.halt, None);
        let rows = |name: &str| column(text, routines, &memory, &format!("{name}@ONE"));
        let (strain, damage, status) = (rows("PEEQ"), rows("SDEG"), rows("STATUS"));
        let gone = status.iter().position(|s| *s == 0.0).expect("it goes");
        let begun = damage.iter().position(|d| *d > 0.0).expect("damage");
        for i in begun..gone {
            let slope = (damage[i] - damage[begun]) / (strain[i] - strain[begun]);
            assert!(i == begun || (slope / (length / 0.2) - 1.0).abs() < 1e-9, "{i}: {slope}");
        }
        let volume = std::f64::consts::PI * (9.0 - 1.0) * 2.0;
        let expected = volume * 10.0 * (0.1 + 0.2 / (2.0 * length) + 10.0 / (6.0 * 10_000.0));
        // Deleted within one increment of plastic strain after p0 + u_f / L.
        let excess = strain[gone] - (0.1 + 0.2 / length);
        assert!(excess.abs() < 3e-4, "{excess}");
        let last = |name: &str| column(text, routines, &memory, name).pop().expect("a row");
        let got = last("ALLPD") + last("ALLDMD");
        println!("length {length}: ALLPD + ALLDMD {got}, closed form {expected}, ratio {}", got / expected);
        // Increments of strain of 1e-4.
        assert!((got / expected - 1.0).abs() < 1e-3, "{got} {expected}");
    }
}

/// Returns twice the default length.
struct DoubledLength;

impl UserLengths for DoubledLength {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        assert!(call.corners == 4 && call.nodes.len() == 8 * call.count && call.name == "M");
        lengths.iter_mut().for_each(|l| *l *= call.properties[0]);
        Ok(())
    }
}

/// User material that stores the length it receives.
struct LengthRecorder;

impl UserFields for LengthRecorder {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        answer.state[..call.count].copy_from_slice(call.length);
        Ok(())
    }
}

#[test]
fn user_length_reaches_materials_and_zero_halts() {
    let card = |factor: &str| {
        let cards = format!(
            "*Elastic\n 1000., 0.3\n*User Defined Field\n*Depvar\n 1,\n*Characteristic Length, definition=USER, properties=1\n {factor},\n"
        );
        stretched(&cards, " SDV1\n")
    };
    let routines = || Routines::none().with_fields(LengthRecorder).with_lengths(DoubledLength);
    let text = card("2.");
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let got = column(&text, &routines(), &memory, "SDV1@ONE");
    // Twice the square root of the area, which grows from 1 to 2.
    assert!((got.last().expect("a row") - 2.0 * 2f64.sqrt()).abs() < 2e-3, "{got:?}");
    let (outcome, _) = common::run(&card("0."), &[], &routines());
    let halt = outcome.halt.expect("a halt");
    assert!(halt.message().contains("charLength(k, 1) = 0") && halt.message().contains("element 1"), "{halt:?}");
    let missing = revolve::job::prepare_text("test.inp", &text, &[], &Routines::none().with_fields(LengthRecorder));
    let message_text = missing.diagnostics.render(&missing.deck.sources);
    assert!(message_text.contains("P004") && message_text.contains("vucharlength"), "{message_text}");
}

const STOPS: &str = "
subroutine vuamp(ampName, time, ampValueOld, dt, nprops, props, nSvars, svars, lFlagsInfo, nSensor, sensorValues, sensorNames, &
    jSensorLookUpTable, ampValueNew, lFlagsDefine, ampDerivative, ampSecDerivative, ampIncIntegral)
  include 'vaba_param.inc'
  dimension time(2), props(nprops), svars(nSvars), lFlagsInfo(*), sensorValues(nSensor), lFlagsDefine(*)
  character*80 sensorNames(nSensor), ampName
  i = ivGetSensorID('WATCHED', jSensorLookUpTable)
  v = vGetSensorValue('WATCHED', jSensorLookUpTable, sensorValues)
  if (v .ne. sensorValues(i)) call xplb_exit
  if (v .le. props(1)) svars(1) = 1.d0
  ampValueNew = 1.d0 - svars(1)
end subroutine
";

/// A bar in uniaxial strain without Poisson's ratio, loaded at its end by a pressure p: until the reflected wave
/// arrives at 2 L / c, the end moves at p / (rho c); it stops when the pressure is removed. The user amplitude removes
/// the pressure when the displacement of the end reaches -0.05, at t = 0.5, or when the velocity at the centre reaches
/// half of p / (rho c), as the wave passes at t = 0.5. In both cases the final displacement of the end is -0.05. Two
/// meshes: the error of the first sensor is one time increment, that of the second the width of the numerical wave
/// front.
#[test]
fn amplitude_stops_at_the_value_of_a_sensor() {
    if !common::fortran("amplitudes of the user in Fortran") {
        return;
    }
    let routines = compiled(STOPS).expect("it compiles");
    for (watched, variable, limit, bound) in [("TIP", "U2", "-0.05", 0.05), ("MIDDLE", "V2", "-0.05", 0.08)] {
        let mut errors = Vec::new();
        for m in [50, 100] {
            let middle = 1 + m / 2 * 2;
            let deck = grid(1, m, false, |i, j| [i as f64, 10.0 * j as f64 / m as f64])
                + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 100., 0.\n"
                + &format!("*Nset, nset=TIP\n {},\n*Nset, nset=MIDDLE\n {middle},\n", 1 + 2 * m)
                + &format!("*Amplitude, name=PUSH, definition=USER, properties=1, variables=1\n {limit},\n")
                + "*Step\n*Dynamic, Explicit\n , 1.5\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Dsload, amplitude=PUSH\n J1, P, 1.\n"
                + &format!(
                    "*Output, history, sensor, name=WATCHED, number interval=10\n*Node Output, nset={watched}\n {variable}\n"
                )
                + "*Output, history, op=ADD, number interval=10\n*Node Output, nset=TIP\n U2\n*End Step\n";
            let (outcome, memory) = common::run(&deck, &[], &routines);
            assert_eq!(outcome.halt, None);
            let end = column(&deck, &routines, &memory, "U2@TIP").pop().expect("a row");
            errors.push((end / -0.05 - 1.0).abs());
        }
        println!("{variable}@{watched}: errors {errors:?}");
        assert!(errors[1] < errors[0] && errors[1] < bound, "{variable}@{watched}: {errors:?}");
    }
}
