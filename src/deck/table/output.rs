//! Cards that ask for results and for states to go on from.
//! Never here: output variables.

use super::row;
use crate::deck::keywords::Keyword;

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("OUTPUT", "Requests results", (step), {
        "FIELD" read "Pictures of the whole model",
        "HISTORY" read "Curves over time",
        "DIAGNOSTICS" inert "of implicit analyses",
        "OP" read "NEW (default) ends all requests of earlier steps, REPLACE those of its type and frequency, ADD none",
        "NAME" read "Name of a sensor",
        "VARIABLE" read "PRESELECT or ALL",
        "FREQUENCY" read "Every so many increments; 0 for never",
        "NUMBER INTERVAL" read "So many times in the step",
        "TIME INTERVAL" read "Every so much time",
        "TIME MARKS" read "YES: at the first increment at or past each mark, with a note; NO (default for history)",
        "TIME POINTS" read "Name of *TIME POINTS: at the first increment at or past each of them",
        "FILTER" inert "output is not filtered: it holds what is computed",
        "SENSOR" read "A history that a user amplitude reads by its NAME",
        "MODE LIST" refused "of modal analyses",
        "INTERNAL" inert "written by CAE; no meaning",
    }, []),
    row!("NODE OUTPUT", "Nodal variables of an *OUTPUT request", (), {
        "NSET" read "Nodes",
        "VARIABLE" read "PRESELECT or ALL",
        "EXTERIOR" refused "give NSET",
        "TRACER SET" refused "meshes are not adaptive",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "nodal variable")]),
    row!("ELEMENT OUTPUT", "Element variables of an *OUTPUT request; a first line of numbers names section points of shells: 1 the side SNEG, the last the side SPOS, or the middle one", (), {
        "ELSET" read "Elements",
        "VARIABLE" read "PRESELECT or ALL",
        "DIRECTIONS" inert "the directions are r, z and the hoop",
        "POSITION" read "INTEGRATION POINTS (default) or CENTROIDAL, which are the same; NODES or AVERAGED AT NODES: in frames, on nodes the mean over the elements around",
        "EXTERIOR" refused "give ELSET",
        "REBAR" refused "of reinforcement",
        "SECTION POINTS" refused "of shells and beams",
        "ALL SECTION POINTS" refused "of shells and beams",
        "TRACER SET" refused "meshes are not adaptive",
        "MICROMECHANICS" refused "of composites",
        "FILTER" inert "output is not filtered: it holds what is computed",
        "ELASTIC DEFORMATION" refused "of implicit analyses",
    }, [(list "element variable")]),
    row!("ENERGY OUTPUT", "Energies of an *OUTPUT request", (), {
        "ELSET" read "Elements; the whole model if absent",
        "VARIABLE" read "PRESELECT or ALL",
        "PER ELEMENT SET" refused "give a request for each set",
        "PER CONTACT SURFACE" refused "energies are of the whole model",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "energy")]),
    row!("INCREMENTATION OUTPUT", "Increment size and added mass of an *OUTPUT request", (), {
        "VARIABLE" read "PRESELECT or ALL",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "incrementation variable")]),
    row!("TIME POINTS", "Times of the step at which an *OUTPUT writes", (unique "NAME"), {
        "NAME" read "Name that *OUTPUT gives",
        "GENERATE" read "Data lines give first, last and increment",
        "INPUT" read "File with the data lines",
    }, [
        (when "GENERATE" = "" rows ["first time", "last time", "increment"]),
        (list "time" read "Ascending"),
    ]),
    row!("INTEGRATED OUTPUT SECTION", "A surface that integrals are taken over", (unique "NAME"), {
        "NAME" read "Name of the section",
        "SURFACE" read "Surface of element faces",
        "ORIENTATION" refused "integrals are taken along r and z",
        "POSITION" refused "integrals are taken along r and z",
        "PROJECT ORIENTATION" only ["NO"] "integrals are taken along r and z",
        "REF NODE" refused "the mean motion of a section is not followed",
        "REF NODE MOTION" refused "the mean motion of a section is not followed",
    }, []),
    row!("INTEGRATED OUTPUT", "Forces through a surface of an *OUTPUT, HISTORY request", (), {
        "SECTION" read "Section",
        "SURFACE" read "Surface of element faces, without a section",
        "ELSET" refused "give SURFACE or SECTION",
        "VARIABLE" read "PRESELECT or ALL",
        "FILTER" refused "histories are not filtered",
    }, [(list "variable")]),
    row!("RESTART", "States to go on from with `revolve run --resume`; before the first step it holds for all", (once step), {
        "WRITE" read "Write <job>.checkpoint; it holds the last state, and goes when the run is complete",
        "READ" refused "to go on with a halted run, use `revolve run --resume`",
        "FREQUENCY" read "Every so many increments; 0 for never",
        "NUMBER INTERVAL" read "So many times in the step (default 1)",
        "TIME MARKS" read "YES: at the first increment at or past each mark, with a note",
        "OVERLAY" inert "only the last state is ever kept",
        "SINGLE" refused "of READ",
        "STEP" refused "of READ",
        "INC" refused "of READ",
        "INTERVAL" refused "of READ",
        "ITERATION" refused "of READ",
        "END STEP" refused "of READ",
    }, []),
];
