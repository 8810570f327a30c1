//! Friction on surfaces whose elements are deleted.
//!
//! Goal: friction never creates energy. Source: the second law. The tolerance and its reason are stated at the test.

use crate::common::solid::{column, grid, last, run};

/// Radii of the nodes of the plate, m.
const RADII: [f64; 9] = [0.0, 1.84e-3, 3.69e-3, 5.53e-3, 7.38e-3, 9.64e-3, 12.7e-3, 16.8e-3, 22.4e-3];

/// Returns a copper plate of 13.4 mm and a rigid sphere with a radius of 3.35 mm and 5 times its own mass.
fn sphere_through_copper(speed: f64) -> String {
    grid(8, 8, false, |i, j| [RADII[i], 1.676e-3 * (j as f64 - 8.0) - 1e-5])
        + "*Node, nset=REF\n 900, 0., 0.\n*Element, type=MASS, elset=POINT\n 901, 900\n*Mass, elset=POINT\n 0.01635\n\
           *Surface, type=SEGMENTS, name=NOSE\n START, 0., 6.7e-3\n CIRCL, 3.35e-3, 3.35e-3, 0., 3.35e-3\n\
           \x20CIRCL, 0., 0., 0., 3.35e-3\n*Rigid Body, ref node=900, analytical surface=NOSE\n\
           *Solid Section, elset=SOLID, material=COPPER\n*Material, name=COPPER\n*Density\n 8960.,\n*Elastic\n 124e9, 0.34\n\
           *Plastic, hardening=JOHNSON COOK\n 90e6, 292e6, 0.31, 1.09, 1356., 298.\n\
           *Damage Initiation, criterion=JOHNSON COOK\n 0.54, 4.89, 3.03, 0.014, 1.12, 1356., 298., 1.\n\
           *Damage Evolution, type=DISPLACEMENT\n 0.,\n*Erosion, elset=SOLID, distortion=0.05\n\
           *Surface Interaction, name=DRY\n*Friction\n 0.0794\n*Surface, name=TARGET\n SOLID,\n\
           *Initial Conditions, type=TEMPERATURE\n ALL, 298.\n"
        + &format!(
            "*Initial Conditions, type=VELOCITY\n 900, 2, {}\n*Step\n*Dynamic, Explicit\n , 4.74e-4\n*Boundary\n I1, 1, 2\n\
             *Contact Pair, interaction=DRY\n TARGET, NOSE\n*Output, history, number interval=200\n\
             *Energy Output\n ALLFD, EROMASS\n*End Step\n",
            -speed
        )
}

/// ALLFD never decreases while elements are deleted under the sphere. The damping of friction acts on facets: a node that
/// has lost its elements has no damping. The tolerance is the rounding of the sum, relative to the initial energy.
#[test]
fn friction_on_eroding_plates_only_dissipates() {
    for speed in (0..12).map(|i| 162.0 + 12.0 * i as f64) {
        let text = sphere_through_copper(speed);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None, "{speed} m/s");
        let friction = column(&text, &memory, "ALLFD");
        let decrease = friction.windows(2).map(|w| w[0].1 - w[1].1).fold(0.0_f64, f64::max) / outcome.energy.initial;
        println!("{speed} m/s: largest decrease of ALLFD {decrease:.1e}");
        assert!(decrease < 1e-6 && last(&text, &memory, "EROMASS") > 0.0, "{speed} m/s: {decrease}");
    }
}
