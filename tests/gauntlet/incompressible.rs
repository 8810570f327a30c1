//! The incompressible limit.

use crate::common::spheres::EVEN;
use crate::meshes::bar;
use crate::scene::{GauntletRun, deck, off};
use crate::{CaseVerdict, cases};

cases! { "Incompressible limit":
    nearly_incompressible_cylinder, "nu = 0.4999: locking, checkerboard pressures",
        "u(a) of Lame within 0.1 %, mean stress of all elements within 2 % of its uniform value";
    fully_plastic_cylinder, "fully plastic thick cylinder: locking raises the limit load",
        "limit pressure 2Y/sqrt(3) ln(b/a) within 1 %, neighbours along z equal within 1 %";
    triangles_of_one_diagonal, "copper bar of triangles with one diagonal: plastic locking",
        "length within 1 %, foot within 3 % of the bar in quadrilaterals (10x50), drift < 0.2 %";
}

fn triangles_of_one_diagonal() -> CaseVerdict {
    let [(_, quads), (scene, found)] = [false, true].map(|triangles| bar(triangles, EVEN));
    let holds = scene.completed(2e-3) && off(found[0], quads[0]) < 0.01 && off(found[1], quads[1]) < 0.03;
    CaseVerdict {
        figure: format!("{:.2} and {:.2} mm, {:.2} and {:.2}", found[0], found[1], quads[0], quads[1]),
        holds,
    }
}

fn settled(scene: &GauntletRun, name: &str) -> f64 {
    let values = scene.column(name);
    let tail = &values[values.len() - values.len() / 5..];
    tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
}

fn nearly_incompressible_cylinder() -> CaseVerdict {
    let scene = deck("cylinder.inp", &[("nu", "0.4999")]);
    // Plane strain, p = 1: u(a) = (1 + nu) a/E ((1 - 2 nu) a^2 + b^2)/(b^2 - a^2); mean stress 2 (1 + nu)/3 a^2/(b^2 -
    // a^2).
    let (nu, a, b) = (0.4999, 10.0, 20.0);
    let exact = (1.0 + nu) * a / 200e3 * ((1.0 - 2.0 * nu) * a * a + b * b) / (b * b - a * a);
    let mean = 2.0 * (1.0 + nu) / 3.0 * a * a / (b * b - a * a);
    let error = off(settled(&scene, "U1@FIRST"), exact);
    let worst = scene.cells().iter().map(|c| off(c.mean, mean)).fold(0.0, f64::max);
    let holds = scene.completed(1e-2) && error < 1e-3 && worst < 0.02;
    CaseVerdict {
        figure: format!("u(a) within {:.2} %, mean stress within {:.1} %", 100.0 * error, 100.0 * worst),
        holds,
    }
}

/// A pressure slightly below the limit load is carried, one slightly above it is not.
fn fully_plastic_cylinder() -> CaseVerdict {
    let yield_stress = 200.0;
    let limit = 2.0 / 3f64.sqrt() * yield_stress * 2f64.ln();
    // Stiffness and density are a hundredfold, so that strains are as small as the theory assumes.
    let press = |share: f64| {
        let p = (share * limit).to_string();
        let settings = [
            ("nu", "0.3"),
            ("Y", "200."),
            ("p", p.as_str()),
            ("E", "200.e5"),
            ("rho", "7.85e-7"),
            ("time", "1.e-3"),
            ("ramp", "5.e-4"),
        ];
        deck("cylinder.inp", &settings)
    };
    let (below, above) = (press(0.99), press(1.01));
    let opened = |scene: &GauntletRun| settled(scene, "U1@FIRST");
    let cells = below.cells();
    let rows: Vec<&[crate::scene::ElementValues]> = cells.chunks(10).collect();
    let uneven = (0..10)
        .flat_map(|i| rows.iter().map(move |row| (i, row)))
        .map(|(i, row)| (row[i].mean - rows[0][i].mean).abs() / yield_stress);
    let uneven = uneven.fold(0.0, f64::max);
    let ratio = opened(&above) / opened(&below);
    let holds = below.outcome.halt.is_none() && uneven < 0.01 && opened(&below) < 0.01 && ratio > 10.0;
    let figure = format!("u(a) {:.4} mm at 0.99, {ratio:.0} times that at 1.01", opened(&below));
    CaseVerdict { figure, holds }
}
