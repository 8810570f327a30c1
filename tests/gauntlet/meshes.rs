//! The same scenes on meshes that are skewed and stretched.

use crate::common::solid::{copper_bar, grid, material};
use crate::common::spheres::{self, EVEN, SKEWED, STRETCHED, Warp};
use crate::scene::{Scene, off, text};
use crate::{Verdict, cases};
use revolve::user::Routines;

cases! { "Skewed and stretched meshes":
    shell_skewed, "an imploding shell on slanting elements: rays that run ahead, elements that fold",
        "every ray of 20x20 stops within 2 % of the radius 4, drift < 0.1 %";
    shell_stretched, "the same on elements that are stretched fourfold both ways",
        "every ray of 20x20 stops within 2 % of the radius 4, drift < 0.1 %";
    vessel_skewed, "a thick sphere under pressure on slanting elements: hourglass control that resists a linear strain",
        "inner radius of every ray widened as by Lame: order above 1.5 from 10x10 to 20x20, there within 2 %, drift < 0.5 %";
    vessel_stretched, "the same on stretched elements",
        "inner radius of every ray widened as by Lame: order above 1.5 from 10x10 to 20x20, there within 1 %, drift < 0.5 %";
    bar_skewed, "a copper bar that mushrooms on slanting elements",
        "length within 0.3 %, foot within 2 % of that on 10x50 even elements, drift < 0.2 %";
    bar_stretched, "the same on elements finest on the axis and at the rear",
        "length within 0.5 %, foot within 3 % of that on 10x50 even elements, drift < 0.2 %";
    noh_stretched, "a cold gas runs into a wall through elements four times as long there as ahead of them",
        "density 4 within 1 % between wall and shock, shock at 0.2 within 3 %, drift < 1e-9";
}

fn shell(warp: Warp) -> Verdict {
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
    Verdict { figure, holds: scene.completed(1e-3) && worst < 0.02 }
}

fn shell_skewed() -> Verdict {
    shell(SKEWED)
}

fn shell_stretched() -> Verdict {
    shell(STRETCHED)
}

/// Timoshenko and Goodier, section 136: u(a) = p a/(E (b^3 - a^3)) ((1 - 2 nu) a^3 + (1 + nu) b^3/2), a = 1, b = 2.
fn widened(warp: Warp, n: usize) -> f64 {
    let (e, nu, p) = (200e3, 0.3, 1.0);
    let place = |i: usize, j: usize| {
        let [x, y] = warp([i as f64 / n as f64, j as f64 / n as f64]);
        spheres::direction(y).map(|d| (1.0 + x) * d)
    };
    let mut deck = grid(n, n, false, place) + &material(e, nu, 7.85e-9, "");
    for j in 0..=n {
        deck += &format!("*Nset, nset=RAY{j}\n {},\n", 1 + j * (n + 1));
    }
    // The sphere breathes with about 2 microseconds.
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

fn vessel(warp: Warp, within: f64) -> Verdict {
    let [coarse, fine] = [10, 20].map(|n| widened(warp, n));
    let order = (coarse / fine).log2();
    let figure = format!("{:.1} and {:.2} %, order {order:.1}", 100.0 * coarse, 100.0 * fine);
    Verdict { figure, holds: fine < within && order > 1.5 }
}

fn vessel_skewed() -> Verdict {
    vessel(SKEWED, 0.02)
}

fn vessel_stretched() -> Verdict {
    vessel(STRETCHED, 0.01)
}

/// Length and foot of the bar, mm.
pub fn bar(triangles: bool, warp: Warp) -> (Scene, [f64; 2]) {
    let scene = text(&copper_bar([10, 50], triangles, warp), &Routines::none());
    let found = ["COOR2@TIP", "COOR1@RIM"].map(|name| scene.last(name));
    (scene, found)
}

fn bar_against_even(warp: Warp, bars: [f64; 2]) -> Verdict {
    let (_, even) = bar(false, EVEN);
    let (scene, found) = bar(false, warp);
    let figure = format!("{:.2} and {:.2} mm, {:.2} and {:.2} on even ones", found[0], found[1], even[0], even[1]);
    let near = (0..2).all(|i| off(found[i], even[i]) < bars[i]);
    Verdict { figure, holds: scene.completed(2e-3) && near }
}

fn bar_skewed() -> Verdict {
    bar_against_even(SKEWED, [0.003, 0.02])
}

fn bar_stretched() -> Verdict {
    bar_against_even(STRETCHED, [0.005, 0.03])
}

fn noh_stretched() -> Verdict {
    let mesh = grid(1, 100, false, |i, j| [0.01 * i as f64, STRETCHED([0.0, 0.01 * j as f64])[1]]);
    let scene = crate::shocks::noh(mesh, " ALL, 2, -1.\n", " ALL, 1, 1\n J0, 2, 2\n");
    let plateau = crate::shocks::density(&scene, |p| p[1], 0.08, 0.16);
    let cells = scene.cells();
    let shock = cells.iter().filter(|c| c.density > 2.0).map(|c| c.place[1]).fold(0.0, f64::max);
    let holds = scene.completed(1e-9) && off(plateau, 4.0) < 0.01 && off(shock, 0.2) < 0.03;
    Verdict { figure: format!("density {plateau:.2}, shock at {shock:.3}"), holds }
}
