//! Decks in the manner of the Python package abapy (L. Charleux): upper case, blanks around `=`, a comma at the end of
//! lines of elements, all data of a part as sets, nodes outside parts of the assembly.

use std::fmt::Write;

use crate::grid::{Grid, Side, graded, list};
use crate::run::{Deck, assert_near};

/// Returns a part with its mesh and sets.
fn part(name: &str, grid: &Grid, element: &str) -> String {
    let rule = "**----------------------------------\n";
    let mut text = format!("*PART, NAME = {name}\n{rule}** NODES\n{rule}*NODE, NSET=ALL_NODES\n");
    for (i, [r, z]) in grid.points().into_iter().enumerate() {
        let _ = writeln!(text, "  {}, {r:?}, {z:?}, 0.0", i + 1);
    }
    for (set, side) in [("TOP_NODES", Side::Top), ("BOTTOM_NODES", Side::Bottom), ("AXIS_NODES", Side::Inner)] {
        let nodes = list(&grid.side_nodes(side), 9, 1).replace('\n', ",\n");
        let _ = write!(text, "*NSET, NSET={set}\n{nodes}");
    }
    let _ = write!(text, "{rule}** ELEMENTS\n{rule}*ELEMENT, TYPE={element}, ELSET={element}_ELEMENTS\n");
    for (i, [a, b, c, d]) in grid.quads().into_iter().enumerate() {
        let _ = writeln!(text, "  {}, {a}, {b}, {c}, {d}, ", i + 1);
    }
    let elements = list(&(1..=grid.elements()).collect::<Vec<_>>(), 9, 1).replace('\n', ",\n");
    let _ = write!(text, "*ELSET, ELSET=ALL_ELEMENTS\n{elements}");
    let faces: String = grid.side_elements(Side::Top).iter().map(|e| format!("  {e}, S3\n")).collect();
    text + &format!(
        "*SURFACE, TYPE=ELEMENT, NAME=SAMPLE_SURFACE\n{faces}*SOLID SECTION, ELSET=ALL_ELEMENTS, MATERIAL=SAMPLE_MAT\n*END PART\n"
    )
}

/// Returns an indentation by a rigid cone.
pub fn indentation(element: &str, depth: f64, time: f64) -> String {
    let steps = graded(14, 0.2, 1.3, 24.0);
    let grid = Grid { r: steps.clone(), z: steps.iter().rev().map(|z| -z).collect() };
    let height = 4.0 / 70.3_f64.to_radians().tan();
    format!(
        "**----------------------------------\n**INDENTATION SIMULATION\n**----------------------------------\n\
         *PREPRINT, ECHO=NO, MODEL=NO, HISTORY=NO, CONTACT=NO\n{}*PART, NAME = P_INDENTER\n*END PART\n\
         *ASSEMBLY, NAME = ASSEMBLY\n*INSTANCE, NAME = I_SAMPLE, PART = P_SAMPLE\n*END INSTANCE\n\
         *INSTANCE, NAME = I_INDENTER, PART= P_INDENTER\n*NODE, NSET=REF_NODE\n 1, 0., 0., 0.\n\
         *SURFACE, TYPE=SEGMENTS, NAME=RIGID_SURFACE\nSTART, 4.0, {height:?}\nLINE, 0.0, 0.0\n\
         *RIGID BODY, REF NODE = REF_NODE, ANALYTICAL SURFACE = RIGID_SURFACE\n*END INSTANCE\n*END ASSEMBLY\n\
         *SURFACE INTERACTION, NAME = SURF_INTERACTION\n*FRICTION\n0.0,\n\
         *MATERIAL, NAME = SAMPLE_MAT\n*ELASTIC\n200000.0, 0.3\n*DENSITY\n7.8e-09\n*PLASTIC\n300.0, 0.0\n\
         *AMPLITUDE, NAME = LOADING, DEFINITION = SMOOTH STEP\n0.0, 0.0, {time:?}, 1.0\n\
         *STEP, NAME = LOADING, NLGEOM = YES, INC=10000\n*DYNAMIC, EXPLICIT\n, {time:?}\n*FIXED MASS SCALING, FACTOR = 10.\n\
         *BOUNDARY\nI_SAMPLE.AXIS_NODES, 1, 1\nI_SAMPLE.BOTTOM_NODES, 1, 2\nI_INDENTER.REF_NODE, 1, 1\nI_INDENTER.REF_NODE, 6, 6\n\
         *BOUNDARY, AMPLITUDE = LOADING\nI_INDENTER.REF_NODE, 2, 2, {:?}\n\
         *CONTACT PAIR, INTERACTION = SURF_INTERACTION, MECHANICAL CONSTRAINT = PENALTY, CPSET = INDENTATION\nI_INDENTER.RIGID_SURFACE, I_SAMPLE.SAMPLE_SURFACE\n\
         *OUTPUT, FIELD, NUMBER INTERVAL = 2\n*NODE OUTPUT\nU, RF\n*ELEMENT OUTPUT\nS, PEEQ\n\
         *OUTPUT, HISTORY, TIME INTERVAL = {:?}\n*NODE OUTPUT, NSET = I_INDENTER.REF_NODE\nRF2, U2\n\
         *CONTACT OUTPUT, CPSET = INDENTATION\nCAREA\n*ENERGY OUTPUT\nALLFD, ALLWK, ALLKE, ALLIE, ETOTAL\n*END STEP\n",
        part("P_SAMPLE", &grid, element),
        -depth,
        time / 200.0
    )
}

/// A rigid cone of the Berkovich-equivalent angle indents a perfectly plastic half space.
///
/// Estimate: the mean pressure of fully plastic indentation is 2.8 times the yield stress (Tabor, The Hardness of
/// Metals, 1951; Johnson, Contact Mechanics, chapter 6). The area is that of the nodes in contact, up to half a facet
/// too large: tolerance 18 %. The force grows with the square of the depth (Kick's law): tolerance 10 %.
#[test]
fn cone_indentation_has_the_hardness_of_tabor() {
    let time = 5e-4;
    // The tip squashes the elements below it.
    let run = Deck::new(&indentation("CAX4R", 0.8, time)).completes(&["R319"]);
    let force = |from: f64, to: f64| run.mean("RF2@I_INDENTER.REF_NODE", from * time, to * time).abs();
    let area = run.mean(run.columns_with("CAREA")[0], 0.95 * time, time);
    assert_near("hardness", force(0.95, 1.0) / area, 2.8 * 300.0, 0.18);
    // The smooth step is at half its height in the middle of the step.
    assert_near("force at twice the depth", force(0.95, 1.0) / force(0.48, 0.52), 4.0, 0.1);
}

/// Elements with full integration, the default of the package, give one message with the type to use.
#[test]
fn fully_integrated_elements_name_the_type_to_use() {
    let finished = Deck::new(&indentation("CAX4", 0.6, 1e-3)).fails(&["M121"]);
    assert!(finished.printed.contains("CAX4R"));
}
