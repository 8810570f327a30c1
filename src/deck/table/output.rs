//! Cards that ask for results and for states to go on from.
//! Never here: output variables.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, INTEGER, NUMBER, POSITIVE, ZERO, word};

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("OUTPUT", "Requests results", (step), {
        "FIELD" read "Pictures of the whole model",
        "HISTORY" read "Curves over time",
        "DIAGNOSTICS" inert "of implicit analyses",
        "OP" (word(&["NEW", "ADD", "REPLACE"]).or(0.0)) "NEW ends all requests of earlier steps, REPLACE those of its type and frequency, ADD none",
        "NAME" read "Name of a sensor",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "FREQUENCY" (INTEGER.from(0.0)) "Every so many increments; 0 for never",
        "NUMBER INTERVAL" (COUNT) "So many times in the step",
        "TIME INTERVAL" (POSITIVE) "Every so much time",
        "TIME MARKS" read "YES: at the first increment at or past each mark, with a note; NO (default for history)",
        "TIME POINTS" read "Name of *TIME POINTS: at the first increment at or past each of them",
        "FILTER" inert "output is not filtered: it holds what is computed",
        "SENSOR" read "A history that a user amplitude reads by its NAME",
        "MODE LIST" refused "of modal analyses",
        "INTERNAL" inert "written by CAE; no meaning",
    }, []),
    row!("NODE OUTPUT", "Nodal variables of an *OUTPUT request", (), {
        "NSET" read "Nodes",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "STATISTICS" extension "Of histories: MIN, MAX, MEAN or SUM over the set in place of a column for each node, several as in \"MIN, MAX\"; MEAN is not weighted, and RF of a rigid body counts once",
        "EXTERIOR" refused "give NSET",
        "TRACER SET" refused "meshes are not adaptive",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "nodal variable")]),
    row!("ELEMENT OUTPUT", "Element variables of an *OUTPUT request; a first line of numbers names section points of shells: 1 the side SNEG, the last the side SPOS, or the middle one", (), {
        "ELSET" read "Elements",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "STATISTICS" extension "Of histories: MIN, MAX, MEAN or SUM over the set in place of a column for each element, several as in \"MIN, MAX\"; without deleted elements, but for STATUS; MEAN is weighted by the volumes now, of variables of whole elements it is not",
        "DIRECTIONS" inert "the directions are r, z and the hoop",
        "POSITION" (word(&["INTEGRATION POINTS", "CENTROIDAL", "NODES", "AVERAGED AT NODES"]).or(0.0)) "INTEGRATION POINTS and CENTROIDAL are the same; NODES and AVERAGED AT NODES: in frames, on nodes the mean over the elements around",
        "EXTERIOR" refused "give ELSET",
        "REBAR" refused "of reinforcement",
        "TRACER SET" refused "meshes are not adaptive",
        "MICROMECHANICS" refused "of composites",
        "FILTER" inert "output is not filtered: it holds what is computed",
        "ELASTIC DEFORMATION" refused "of implicit analyses",
    } refused {
        "of shells and beams": "SECTION POINTS", "ALL SECTION POINTS";
    }, [(list "element variable")]),
    row!("CONTACT OUTPUT", "Variables of contact of an *OUTPUT request", (), {
        "NSET" read "Nodes of a history",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "CPSET" read "Pairs of this set alone",
        "CONTACT PAIR" extension "Pairs with this surface interaction alone",
        "GENERAL CONTACT" read "Pairs of general contact alone",
        "SURFACE" read "Pairs with this surface alone",
        "SECOND SURFACE" read "Pairs of SURFACE with this one alone",
        "MASTER" read "Pairs with this surface alone",
        "SLAVE" read "Pairs with this surface alone",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "contact variable")]),
    row!("ENERGY OUTPUT", "Energies of an *OUTPUT request", (), {
        "ELSET" read "Elements; the whole model if absent",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "PER ELEMENT SET" refused "give a request for each set",
        "PER CONTACT SURFACE" refused "energies are of the whole model",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "energy")]),
    row!("INCREMENTATION OUTPUT", "Increment size and added mass of an *OUTPUT request", (), {
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "FILTER" inert "output is not filtered: it holds what is computed",
    }, [(list "incrementation variable")]),
    row!(extension "OUTPUT EXPRESSION", "History columns that follow from others, row by row; in force in all steps", (), {}, [
        (text "name = expression" read "Over history columns of the deck, as in SHORTENING = -1000*(U2@TOP - U2@FOOT), `time`, and those defined above; + - * / // % **, functions; not a number where it has no value"),
    ]),
    row!("TIME POINTS", "Times of the step at which an *OUTPUT writes", (unique "NAME"), {
        "NAME" read "Name that *OUTPUT gives",
        "GENERATE" read "Data lines give first, last and increment",
        "INPUT" read "File with the data lines",
    }, [
        (when "GENERATE" = "" rows ["first time" (ZERO), "last time" (ZERO), "increment" (POSITIVE.required())]),
        (list "time" (NUMBER) "Ascending"),
    ]),
    row!("INTEGRATED OUTPUT SECTION", "A surface that integrals are taken over", (unique "NAME"), {
        "NAME" read "Name of the section",
        "SURFACE" read "Surface of element faces",
        "PROJECT ORIENTATION" only ["NO"] "integrals are taken along r and z",
    } refused {
        "integrals are taken along r and z": "ORIENTATION", "POSITION";
        "the mean motion of a section is not followed": "REF NODE", "REF NODE MOTION";
    }, []),
    row!("INTEGRATED OUTPUT", "Forces through a surface of an *OUTPUT, HISTORY request", (), {
        "SECTION" read "Section",
        "SURFACE" read "Surface of element faces, without a section",
        "ELSET" refused "give SURFACE or SECTION",
        "VARIABLE" (word(&["PRESELECT", "ALL"])) "Names of variables stand on data lines",
        "FILTER" refused "histories are not filtered",
    }, [(list "variable")]),
    row!("RESTART", "States to go on from with `revolve run --resume`; before the first step it holds for all", (once each step), {
        "WRITE" read "Write <job>.checkpoint; it holds the last state, and goes when the run is complete",
        "READ" refused "to go on with a halted run, use `revolve run --resume`",
        "FREQUENCY" (INTEGER.from(0.0)) "Every so many increments; 0 for never",
        "NUMBER INTERVAL" (COUNT) "So many times in the step (default 1)",
        "TIME MARKS" read "YES: at the first increment at or past each mark, with a note",
        "OVERLAY" inert "only the last state is ever kept",
    } refused {
        "of READ": "SINGLE", "STEP", "INC", "INTERVAL", "ITERATION", "END STEP";
    }, []),
];
