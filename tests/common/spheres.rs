//! Decks of thick spheres and cylinders with nodes on rays: Verney's shell, a rubber sphere.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::solid::{grid, material};

/// Map of the unit square [through the wall, circumferential] onto itself that skews or stretches a mesh.
pub type MeshMap = fn([f64; 2]) -> [f64; 2];

/// Uniform mesh.
pub const EVEN: MeshMap = |x| x;

/// Mesh lines skewed by up to a quarter, with straight edges.
pub const SKEWED: MeshMap = |[x, y]| [x + (y - 0.5) * x * (1.0 - x), y + (x - 0.5) * y * (1.0 - y)];

/// Element lengths that grow fourfold in one direction and shrink fourfold in the other.
pub const STRETCHED: MeshMap = |[x, y]| [(4f64.powf(x) - 1.0) / 3.0, 1.0 - (4f64.powf(1.0 - y) - 1.0) / 3.0];

/// Returns the unit vector at a fraction of the quarter circle from the equator; exactly the axis at 1.
pub fn direction(share: f64) -> [f64; 2] {
    let angle = 0.5 * PI * share;
    if share >= 1.0 { [0.0, 1.0] } else { [angle.cos(), angle.sin()] }
}

/// Returns the initial velocity for which a rigid-plastic incompressible beryllium shell (radii 8 and 10 cm, Y = 0.0033
/// Mbar) stops at an inner radius. Kinetic energy equals plastic work, both by quadrature over the shell (Howell and
/// Ball 2002, J. Comput. Phys. 175, 128, corrected).
pub fn stopping_speed(stop: f64, sphere: bool) -> f64 {
    let (rho, yield_stress, inner, outer) = (1.845_f64, 0.0033, 8.0_f64, 10.0);
    let n = 20_000;
    let h = (outer - inner) / f64::from(n);
    let (mut work, mut mass) = (0.0, 0.0);
    for i in 0..n {
        let r = inner + (f64::from(i) + 0.5) * h;
        if sphere {
            let now = (r.powi(3) - inner.powi(3) + stop.powi(3)).cbrt();
            work += 4.0 * PI * r * r * h * yield_stress * 2.0 * (r / now).ln();
            mass += 4.0 * PI * r * r * h * 0.5 * rho * (inner / r).powi(4);
        } else {
            let now = (r * r - inner * inner + stop * stop).sqrt();
            work += 2.0 * PI * r * h * yield_stress * 2.0 / 3f64.sqrt() * (r / now).ln();
            mass += 2.0 * PI * r * h * 0.5 * rho * (inner / r).powi(2);
        }
    }
    (work / mass).sqrt()
}

/// Returns the deck of Verney's shell up to the boundary conditions of a step of 180 microseconds (cm, g, Mbar): `n`
/// elements through the thickness, `around` along the quarter circle of a sphere or along a cylinder, with the velocity
/// for which the inner face stops at the radius `stop`.
pub fn verney(stop: f64, sphere: bool, [n, around]: [usize; 2], warp: MeshMap) -> String {
    let speed = stopping_speed(stop, sphere);
    let polar = |i: usize, j: usize| {
        let [x, y] = warp([i as f64 / n as f64, j as f64 / around as f64]);
        (8.0 + 2.0 * x, y)
    };
    let place = |i: usize, j: usize| match polar(i, j) {
        (radius, y) if sphere => direction(y).map(|d| radius * d),
        (radius, y) => [radius, 0.25 * around as f64 * y],
    };
    let (bulk, shear): (f64, f64) = (1.180, 1.51);
    let nu = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
    let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
    let mut deck = grid(n, around, false, place) + &material(young, nu, 1.845, "*Plastic\n 0.0033, 0.\n");
    deck += "*Initial Conditions, type=VELOCITY\n";
    for (i, j) in (0..=around).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let (radius, y) = polar(i, j);
        let v = -speed * (8.0 / radius).powi(if sphere { 2 } else { 1 });
        let [r, z] = if sphere { direction(y) } else { [1.0, 0.0] };
        let node = 1 + i + j * (n + 1);
        write!(deck, " {node}, 1, {:e}\n {node}, 2, {:e}\n", v * r, v * z).expect("text");
    }
    rays(&mut deck, around, |j| 1 + j * (n + 1));
    let held = if sphere { " J0, 2, 2\n J1, 1, 1\n" } else { " ALL, 2, 2\n" };
    deck + &format!("*Step\n*Dynamic, Explicit\n , 180.\n*Boundary\n{held}")
}

/// Returns the deck of a hollow neo-Hookean sphere of radii 1 and 2 cm, shear modulus 1 MPa and bulk modulus `ratio`
/// times as large, whose inner radius is prescribed to grow threefold within 50 ms. History: COOR1 and COOR2 of the
/// outer nodes, ALLKE, ALLIE.
pub fn rubber_sphere(ratio: f64, [n, m]: [usize; 2], more: &str) -> String {
    let (inner, outer) = (0.01_f64, 0.02_f64);
    let along = |j: usize| direction(j as f64 / m as f64);
    let place = |i: usize, j: usize| along(j).map(|d| (inner + (outer - inner) * i as f64 / n as f64) * d);
    let mut deck = grid(n, m, false, place)
        + &format!(
            "*Solid Section, elset=SOLID, material=R\n*Material, name=R\n*Density\n 1000.,\n*Hyperelastic, neo hooke\n 5.e5, {:e}\n",
            2.0 / (ratio * 1e6)
        )
        + more;
    rays(&mut deck, m, |j| (n + 1) * (j + 1));
    deck += "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 0.05, 1.\n*Step\n*Dynamic, Explicit\n , 0.05\n*Boundary\n J0, 2, 2\n J1, 1, 1\n*Boundary, amplitude=A\n";
    for j in 0..=m {
        let [r, z] = along(j);
        let node = 1 + j * (n + 1);
        if j < m {
            writeln!(deck, " {node}, 1, 1, {:e}", 2.0 * inner * r).expect("text");
        }
        if j > 0 {
            writeln!(deck, " {node}, 2, 2, {:e}", 2.0 * inner * z).expect("text");
        }
    }
    deck += "*Output, history, number interval=20\n*Energy Output\n ALLKE, ALLIE\n";
    deck + &coordinates(m) + "*End Step\n"
}

/// Returns the final outer radius of [`rubber_sphere`] at constant volume.
pub fn blown_up() -> f64 {
    (0.02f64.powi(3) + 26.0 * 0.01f64.powi(3)).cbrt()
}

/// Adds node sets RAY0, RAY1, … of one node each.
fn rays(deck: &mut String, around: usize, node: impl Fn(usize) -> usize) {
    for j in 0..=around {
        write!(deck, "*Nset, nset=RAY{j}\n {},\n", node(j)).expect("text");
    }
}

/// Returns history requests for the coordinates of the nodes of all rays.
pub fn coordinates(around: usize) -> String {
    (0..=around).map(|j| format!("*Node Output, nset=RAY{j}\n COOR1, COOR2\n")).collect()
}
