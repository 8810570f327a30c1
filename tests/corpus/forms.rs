//! Forms of cards that ABAQUS accepts and that pre-processors and analysts write, each in the smallest deck. Forms that
//! are unsupported have one message.

use crate::abapy::indentation;
use crate::run::Deck;

/// Returns a deck of one element with cards before the step, and cards in the step.
fn element(model: &str, step: &str) -> Deck {
    Deck::new(&format!(
        "*Heading\n*Node, nset=all\n1, 0., 0.\n2, 10., 0.\n3, 10., 10.\n4, 0., 10.\n*Element, type=CAX4R, elset=body\n1, 1, 2, 3, 4\n\
         *Solid Section, elset=body, material=steel\n*Material, name=steel\n*Density\n7.85e-9\n*Elastic\n2e5, 0.3\n\
         *Surface, name=upper\nbody, S3\n{model}*Initial Conditions, type=velocity\nall, 2, 1000.\n\
         *Step\n*Dynamic, explicit\n, 1e-4\n{step}*Output, history, time interval=1e-6\n*Energy output\nALLKE, ALLIE, ALLWK, ETOTAL\n*End Step\n"
    ))
}

/// A node without mass whose degrees of freedom are all fixed is a valid end of a spring.
#[test]
fn spring_to_a_fixed_node_is_accepted() {
    let spring = "*Node\n9, 0., -20.\n*Element, type=SPRINGA, elset=s\n9, 9, 1\n*Spring, elset=s\n\n100.\n";
    element(spring, "*Boundary\n9, 1, 2\n").completes(&[]);
}

/// The reference node of `*MPC, BEAM` receives the mass of its dependent nodes.
#[test]
fn spring_on_the_reference_node_of_an_mpc_is_accepted() {
    let spring = "*Node\n9, 0., 0.\n*Nset, nset=feet\n1, 2\n*Mpc\nBEAM, feet, 9\n*Element, type=SPRING1, elset=s\n9, 9\n\
                  *Spring, elset=s\n2\n100.\n";
    element(spring, "*Boundary\n9, 1, 1\n").completes(&[]);
}

/// At the first touch of a slow indentation all energies are 1e-10 of their later values.
#[test]
fn first_touch_of_a_slow_indentation_gives_no_warning() {
    let deck = indentation("CAX4R", 0.8, 5e-4).replace("CONSTRAINT = PENALTY", "CONSTRAINT = KINEMATIC");
    // A warning of the run is another one: the tip squashes the elements below it.
    Deck::new(&deck).completes(&["R319"]);
}

/// The value after PNU is not used, because VDLOAD defines the load (ABAQUS User Subroutines Reference Guide, VDLOAD).
#[test]
fn magnitude_of_a_user_load_is_listed_as_not_used() {
    if !crate::common::fortran("a constant VDLOAD") {
        return;
    }
    let subroutine = "subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude, curCoords, velocity, dirCos, jltyp, sname, value)
  include 'vaba_param.inc'
  dimension curCoords(nblock,ndim), velocity(nblock,ndim), dirCos(nblock,ndim,ndim), value(nblock)
  character*80 sname
  value = amplitude
end subroutine vdload
";
    let run = element("", "*Dsload\nupper, PNU, 20.\n").with_subroutine("load.f90", subroutine).completes(&[]);
    assert!(run.printed.contains("not used: magnitude 20 of PNU"));
}

/// The data line of a traction has a direction after the magnitude.
#[test]
fn traction_load_is_accepted() {
    element("", "*Dsload\nupper, TRVEC, 1., 0., -1., 0.\n").completes(&[]);
}

/// Nodes of solids have no rotation, so that STRUCTURAL is CONTINUUM.
#[test]
fn structural_coupling_is_accepted() {
    let coupling = "*Node\n9, 0., 10.\n*Coupling, constraint name=c, ref node=9, surface=upper\n*Distributing, coupling=STRUCTURAL\n";
    element(coupling, "").completes(&[]);
}

/// A body of revolution that moves along z only has no rotation.
#[test]
fn rotary_inertia_of_a_body_that_does_not_rotate_is_ignored() {
    let body = "*Node\n9, 0., 20.\n*Surface, type=SEGMENTS, name=disc\nSTART, 10., 20.\nLINE, 0., 20.\n\
                *Rigid Body, ref node=9, analytical surface=disc\n*Element, type=MASS, elset=m\n8, 9\n*Mass, elset=m\n1e-3\n\
                *Element, type=ROTARYI, elset=i\n9, 9\n*Rotary Inertia, elset=i\n0.001, 0., 0.\n";
    // The surface of the body has no contact.
    element(body, "").completes(&["P151"]);
}

/// SMOOTH=0 is the default of tabular amplitudes in ABAQUS/Explicit.
#[test]
fn amplitude_without_smoothing_is_accepted() {
    element("*Amplitude, name=a, smooth=0.\n0., 0., 1e-4, 1.\n", "*Dsload, amplitude=a\nupper, P, 1.\n").completes(&[]);
}

/// A refused parameter is the only message of its card.
#[test]
fn unsupported_forms_have_one_message() {
    element("*Surface, name=both, combine=INTERSECTION\nupper, upper\n", "").fails(&["M104"]);
    let shear = "*Material, name=other\n*Damage Initiation, criterion=SHEAR, ks=0.3\n0.5, 1.7\n";
    element(shear, "").fails(&["M104"]);
}
