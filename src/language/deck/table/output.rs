//! Cards that request output and restart files. The output variables are in `variables/`.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, FLAG, INTEGER, NUMBER, POSITIVE, ZERO, word};

/// Keywords that request output and restart files.
pub const CARDS: &[Keyword] = &[
    row!("OUTPUT", "Requests results", (step), {
        "FIELD" (FLAG) "Frames of the whole model",
        "HISTORY" (FLAG) "Histories over time",
        "DIAGNOSTICS" inert "applies only to implicit analyses",
        "OP" (word(&["NEW", "ADD", "REPLACE"]).or(0.0)) "NEW ends all requests of earlier steps, REPLACE those of the same type and frequency; ADD keeps them",
        "NAME" read "Name of a sensor",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "FREQUENCY" (INTEGER.from(0.0)) "Interval in increments; 0 for no output",
        "NUMBER INTERVAL" (COUNT) "Number of outputs in the step",
        "TIME INTERVAL" (POSITIVE) "Time interval of output",
        "TIME MARKS" (FLAG) "YES: output at the first increment at or after each time mark, with a note; NO is the default for history",
        "TIME POINTS" read "Name of *TIME POINTS; output at the first increment at or after each time",
        "FILTER" inert "output is not filtered; it contains the computed values",
        "SENSOR" (FLAG) "Sensor that a user amplitude reads by its NAME",
        "MODE LIST" refused "applies only to modal analyses",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
    }, []),
    row!("NODE OUTPUT", "Nodal variables of an *OUTPUT request", (), {
        "NSET" read "Nodes",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "STATISTICS" extension "For histories: MIN, MAX, MEAN or SUM over the set in place of a column per node; several as in \"MIN, MAX\". MEAN is not weighted; RF of a rigid body is counted once",
        "EXTERIOR" refused "give NSET",
        "TRACER SET" refused "tracer particles are unsupported",
        "FILTER" inert "output is not filtered; it contains the computed values",
    }, [(list "nodal variable")]),
    row!("ELEMENT OUTPUT", "Element variables of an *OUTPUT request; numbers on the first data line are section points of shells: 1 on side SNEG, the last on side SPOS, or the middle one", (), {
        "ELSET" read "Elements",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "STATISTICS" extension "For histories: MIN, MAX, MEAN or SUM over the set in place of a column per element; several as in \"MIN, MAX\". Deleted elements are excluded, except for STATUS. MEAN is weighted by the current volume, except for whole-element variables",
        "DIRECTIONS" inert "the directions are r, z and hoop",
        "POSITION" (word(&["INTEGRATION POINTS", "CENTROIDAL", "NODES", "AVERAGED AT NODES"]).or(0.0)) "INTEGRATION POINTS and CENTROIDAL are the same; NODES and AVERAGED AT NODES: frames show, at each node, the mean over its elements",
        "EXTERIOR" refused "give ELSET",
        "REBAR" refused "applies only to reinforcement",
        "TRACER SET" refused "tracer particles are unsupported",
        "MICROMECHANICS" refused "applies only to composites",
        "FILTER" inert "output is not filtered; it contains the computed values",
        "ELASTIC DEFORMATION" refused "applies only to implicit analyses",
    } refused {
        "applies only to shells and beams": "SECTION POINTS", "ALL SECTION POINTS";
    }, [(list "element variable")]),
    row!("CONTACT OUTPUT", "Contact variables of an *OUTPUT request", (), {
        "NSET" read "Nodes of a history",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "CPSET" read "Only pairs of this set",
        "CONTACT PAIR" extension "Only pairs with this surface interaction",
        "GENERAL CONTACT" (FLAG) "Only pairs of general contact",
        "SURFACE" read "Only pairs with this surface",
        "SECOND SURFACE" read "Only pairs of SURFACE with this surface",
        "MASTER" read "Only pairs with this surface",
        "SLAVE" read "Only pairs with this surface",
        "FILTER" inert "output is not filtered; it contains the computed values",
    }, [(list "contact variable")]),
    row!("ENERGY OUTPUT", "Energies of an *OUTPUT request", (), {
        "ELSET" read "Elements; the whole model if absent",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "PER ELEMENT SET" refused "give one request per set",
        "PER CONTACT SURFACE" refused "energies are output for the whole model",
        "FILTER" inert "output is not filtered; it contains the computed values",
    }, [(list "energy")]),
    row!("INCREMENTATION OUTPUT", "Time increment and added mass of an *OUTPUT request", (), {
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "FILTER" inert "output is not filtered; it contains the computed values",
    }, [(list "incrementation variable")]),
    row!(extension "OUTPUT EXPRESSION", "History columns computed from other columns; active in all steps", (), {}, [
        (text "name = expression" read "Expression of history columns, `time` and expressions defined before it, as in SHORTENING = -1000*(U2@TOP - U2@FOOT); + - * / // % ** and functions; NaN if it has no value"),
    ]),
    row!("TIME POINTS", "Output times of an *OUTPUT request", (unique "NAME"), {
        "NAME" read "Name that *OUTPUT refers to",
        "GENERATE" (FLAG) "Data lines give first, last and increment",
        "INPUT" read "File with the data lines",
    }, [
        (when "GENERATE" rows ["first time" (ZERO), "last time" (ZERO), "increment" (POSITIVE.required())]),
        (list "time" (NUMBER) "Ascending"),
    ]),
    row!("INTEGRATED OUTPUT SECTION", "Section over which forces are integrated", (unique "NAME"), {
        "NAME" read "Name of the section",
        "SURFACE" read "Surface of element faces",
        "PROJECT ORIENTATION" only ["NO"] "integrals are computed along r and z",
    } refused {
        "integrals are computed along r and z": "ORIENTATION", "POSITION";
        "the mean motion of a section is not computed": "REF NODE", "REF NODE MOTION";
    }, []),
    row!("INTEGRATED OUTPUT", "Section forces of an *OUTPUT, HISTORY request", (), {
        "SECTION" read "Section",
        "SURFACE" read "Surface of element faces, in place of SECTION",
        "ELSET" refused "give SURFACE or SECTION",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables are given on the data lines",
        "FILTER" refused "histories are not filtered",
    }, [(list "variable")]),
    row!("RESTART", "Writes restart files for `revolve run --resume`; before the first step it applies to all steps", (once each step), {
        "WRITE" (FLAG) "Writes <job>.checkpoint with the last state; deleted when the run is complete",
        "READ" refused "to continue a halted run, use `revolve run --resume`",
        "FREQUENCY" (INTEGER.from(0.0)) "Interval in increments; 0 for no output",
        "NUMBER INTERVAL" (COUNT) "Number of restart files in the step (default 1)",
        "TIME MARKS" (FLAG) "YES: at the first increment at or after each time mark, with a note",
        "OVERLAY" inert "only the last state is kept",
    } refused {
        "applies only to READ": "SINGLE", "STEP", "INC", "INTERVAL", "ITERATION", "END STEP";
    }, []),
];
