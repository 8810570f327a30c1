//! Scenes on and near the axis.

use crate::scene::{deck, off, spread, text};
use crate::{CaseVerdict, cases, common::solid};
use revolve::user::Routines;

cases! { "Axis":
    needles, "elements of aspect 1000 on the axis: hoop term of the stable increment, mass of the axis node",
        "strain wave at 167.3555 MPa within 0.5 %, all columns equal within 1e-9, drift < 0.2 %";
    triangles_on_the_axis, "triangles (quadrilaterals with a doubled node) on the axis: infinite or wrong axis force",
        "strain wave at 167.3555 MPa within 1.5 %, drift < 0.5 %";
    a_doubled_node_is_refused, "a quadrilateral written with a doubled node: no area at a corner, division by zero",
        "error with the element number (M123), or treated as a triangle";
    a_void_opens_on_the_axis, "elements on the axis fail first: nodes without elements continue or become NaN",
        "completed, all values finite, void open, drift < 3 %";
}

fn needles() -> CaseVerdict {
    let scene = deck("needle.inp", &[]);
    let stress = scene.column("S22@MIDDLE");
    // The wave passes the centre of the element, at 10.5 mm, after 1.7 microseconds.
    let plateau: Vec<f64> = stress.iter().filter(|s| s.0 > 3e-6 && s.0 < 4.8e-6).map(|s| -s.1 / 1e6).collect();
    let (mean, _) = spread(plateau.into_iter());
    let places = scene.places();
    let row = |j: usize| (1..=3).map(move |i| i + 3 * j);
    let uneven = (1..=40).map(|j| spread(row(j).map(|label| places[scene.node(label)][1])).1).fold(0.0, f64::max);
    let holds = scene.completed(2e-3) && off(mean, 167.3555) < 5e-3 && uneven < 1e-9;
    CaseVerdict { figure: format!("{mean:.1} MPa, columns within {uneven:.0e}"), holds }
}

fn triangles_on_the_axis() -> CaseVerdict {
    let text_of = solid::grid(2, 100, true, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &solid::material(68.9e9, 1.0 / 3.0, 2710.0, "")
        + "*Initial Conditions, type=VELOCITY\n ALL, 2, -10.\n*Nset, nset=BOTTOM, generate\n 1, 3, 1\n\
           *Nset, nset=SIDES, generate\n 1, 301, 3\n*Nset, nset=OUT, generate\n 3, 303, 3\n\
           *Step\n*Dynamic, Explicit\n , 12.e-6\n*Boundary\n BOTTOM, 2, 2\n SIDES, 1, 1\n OUT, 1, 1\n\
           *Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n";
    let scene = text(&text_of, &Routines::none());
    let cells = scene.cells();
    let after_wave = cells.iter().filter(|c| c.place[1] > 0.01 && c.place[1] < 0.06).map(|c| -c.axial / 1e6);
    let (mean, uneven) = spread(after_wave);
    let holds = scene.completed(5e-3) && off(mean, 167.3555) < 0.015;
    CaseVerdict { figure: format!("{mean:.1} MPa, uneven by {:.0} %", 100.0 * uneven), holds }
}

fn a_doubled_node_is_refused() -> CaseVerdict {
    let text_of = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n*Element, type=CAX4R, elset=SOLID\n 7, 1, 2, 3, 3\n"
        .to_owned()
        + &solid::material(1.0, 0.3, 1.0, "")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let prepared = revolve::job::prepare_text("doubled.inp", &text_of, &[], &Routines::none());
    let words = prepared.diagnostics.render(&prepared.deck.sources);
    if prepared.diagnostics.has_errors() {
        return CaseVerdict { figure: "refused: M123".into(), holds: words.contains("M123") && words.contains('7') };
    }
    let scene = text(&text_of, &Routines::none());
    CaseVerdict { figure: "runs as a triangle".into(), holds: scene.completed(1e-3) }
}

fn a_void_opens_on_the_axis() -> CaseVerdict {
    let scene = deck("void.inp", &[]);
    let places = scene.places();
    let finite = places.iter().flatten().all(|x| x.is_finite()) && places.iter().all(|p| p[0] >= -1e-12);
    let gone = scene.field("STATUS").iter().filter(|s| **s == 0.0).count();
    let drift = scene.outcome.energy.drift;
    let figure = format!("{gone} elements deleted, drift {:.1} %", 100.0 * drift);
    CaseVerdict { figure, holds: scene.completed(0.03) && finite && gone > 0 }
}
