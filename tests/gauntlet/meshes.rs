//! The same scenes on skewed and stretched meshes.

use crate::common::solid::{copper_bar, grid, material};
use crate::common::spheres::{self, EVEN, MeshMap, SKEWED, STRETCHED};
use crate::scene::{GauntletRun, off, text};
use crate::{CaseVerdict, cases};
use revolve::user::Routines;

cases! { "Skewed and stretched meshes":
    shell_skewed, "imploding shell on skewed elements: loss of symmetry, folded elements",
        "every ray of 20x20 stops within 2 % of the radius 4, drift < 0.1 %";
    shell_stretched, "the same on elements stretched fourfold in both directions",
        "every ray of 20x20 stops within 2 % of the radius 4, drift < 0.1 %";
    vessel_skewed, "thick sphere under pressure on skewed elements: hourglass control that resists a linear strain",
        "displacement of the inner radius of every ray as by Lame: order above 1.5 from 10x10 to 20x20, within 2 % on 20x20, drift < 0.5 %";
    vessel_stretched, "the same on stretched elements",
        "displacement of the inner radius of every ray as by Lame: order above 1.5 from 10x10 to 20x20, within 1 % on 20x20, drift < 0.5 %";
    bar_skewed, "copper Taylor bar on skewed elements",
        "length within 0.3 %, foot within 2 % of a uniform 10x50 mesh, drift < 0.2 %";
    bar_stretched, "the same with a mesh refined at the axis and at the rear",
        "length within 0.5 %, foot within 3 % of a uniform 10x50 mesh, drift < 0.2 %";
    noh_stretched, "cold gas against a wall, elements four times as long at the wall as before it",
        "density 4 within 1 % between wall and shock, shock at 0.2 within 3 %, drift < 1e-9";
}

fn shell(warp: MeshMap) -> CaseVerdict {
    let deck = spheres::verney(4.0, true, [20, 20], warp)
        + "*Output, history, time interval=0.5\n"
        + &spheres::coordinates(20)
        + "*End Step\n";
    let scene = text(&deck, &Routines::none());
    let stop = |j: usize| {
        let places = scene.column(&format!("COOR1@RAY{j}")).into_iter().zip(scene.column(&format!("COOR2@RAY{j}")));
        places.map(|(r, z)| r.1.hypot(z.1)).fold(f64::INFINITY, f64::min)
    };
    let stops: Vec<f64> = (0..=20).map(stop).collect();
    let mean = stops.iter().sum::<f64>() / 21.0;
    let worst = stops.iter().map(|r| off(*r, 4.0)).fold(0.0, f64::max);
    let figure = format!("mean {mean:.3}, worst ray {:.1} %", 100.0 * worst);
    CaseVerdict { figure, holds: scene.completed(1e-3) && worst < 0.02 }
}

fn shell_skewed() -> CaseVerdict {
    shell(SKEWED)
}

fn shell_stretched() -> CaseVerdict {
    shell(STRETCHED)
}

/// Timoshenko and Goodier, section 136: u(a) = p a/(E (b^3 - a^3)) ((1 - 2 nu) a^3 + (1 + nu) b^3/2), a = 1, b = 2.
fn widened(warp: MeshMap, n: usize) -> f64 {
    let (e, nu, p) = (200e3, 0.3, 1.0);
    let place = |i: usize, j: usize| {
        let [x, y] = warp([i as f64 / n as f64, j as f64 / n as f64]);
        spheres::direction(y).map(|d| (1.0 + x) * d)
    };
    let mut deck = grid(n, n, false, place) + &material(e, nu, 7.85e-9, "");
    for j in 0..=n {
        deck += &format!("*Nset, nset=RAY{j}\n {},\n", 1 + j * (n + 1));
    }
    // The period of the radial vibration is about 2 microseconds.
    deck += "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 20.e-6, 1.\n*Step\n*Dynamic, Explicit\n , 30.e-6\n\
             *Boundary\n J0, 2, 2\n J1, 1, 1\n*Dsload, amplitude=A\n I0, P, 1.\n*Output, history, number interval=300\n";
    deck += &(0..=n).map(|j| format!("*Node Output, nset=RAY{j}\n U1, U2\n")).collect::<String>();
    let scene = text(&(deck + "*End Step\n"), &Routines::none());
    let exact = p / (7.0 * e) * ((1.0 - 2.0 * nu) + 0.5 * (1.0 + nu) * 8.0);
    let settled = |name: String| {
        let values = scene.column(&name);
        let tail = &values[values.len() - 90..];
        tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
    };
    let of = |j: usize| off(settled(format!("U1@RAY{j}")).hypot(settled(format!("U2@RAY{j}"))), exact);
    assert!(scene.completed(5e-3));
    (0..=n).map(of).fold(0.0, f64::max)
}

fn vessel(warp: MeshMap, within: f64) -> CaseVerdict {
    let [coarse, fine] = [10, 20].map(|n| widened(warp, n));
    let order = (coarse / fine).log2();
    let figure = format!("{:.1} and {:.2} %, order {order:.1}", 100.0 * coarse, 100.0 * fine);
    CaseVerdict { figure, holds: fine < within && order > 1.5 }
}

fn vessel_skewed() -> CaseVerdict {
    vessel(SKEWED, 0.02)
}

fn vessel_stretched() -> CaseVerdict {
    vessel(STRETCHED, 0.01)
}

/// Returns the run of a Taylor bar with its final length and foot radius, mm.
pub fn bar(triangles: bool, warp: MeshMap) -> (GauntletRun, [f64; 2]) {
    let scene = text(&copper_bar([10, 50], triangles, warp), &Routines::none());
    let found = ["COOR2@TIP", "COOR1@RIM"].map(|name| scene.last(name));
    (scene, found)
}

fn bar_against_even(warp: MeshMap, bars: [f64; 2]) -> CaseVerdict {
    let (_, even) = bar(false, EVEN);
    let (scene, found) = bar(false, warp);
    let figure = format!("{:.2} and {:.2} mm, uniform mesh {:.2} and {:.2}", found[0], found[1], even[0], even[1]);
    let near = (0..2).all(|i| off(found[i], even[i]) < bars[i]);
    CaseVerdict { figure, holds: scene.completed(2e-3) && near }
}

fn bar_skewed() -> CaseVerdict {
    bar_against_even(SKEWED, [0.003, 0.02])
}

fn bar_stretched() -> CaseVerdict {
    bar_against_even(STRETCHED, [0.005, 0.03])
}

fn noh_stretched() -> CaseVerdict {
    let mesh = grid(1, 100, false, |i, j| [0.01 * i as f64, STRETCHED([0.0, 0.01 * j as f64])[1]]);
    let scene = crate::shocks::noh(mesh, " ALL, 2, -1.\n", " ALL, 1, 1\n J0, 2, 2\n");
    let plateau = crate::shocks::density(&scene, |p| p[1], 0.08, 0.16);
    let cells = scene.cells();
    let shock = cells.iter().filter(|c| c.density > 2.0).map(|c| c.place[1]).fold(0.0, f64::max);
    let holds = scene.completed(1e-9) && off(plateau, 4.0) < 0.01 && off(shock, 0.2) < 0.03;
    CaseVerdict { figure: format!("density {plateau:.2}, shock at {shock:.3}"), holds }
}
