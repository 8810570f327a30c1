use revolve::effect::solid::group::*;
use revolve::effect::solid::law::*;
use revolve::effect::solid::*;
use revolve::state::nodes::Node;
use std::time::Instant;
fn main() {
    for (nr, nz) in [(32usize, 64usize), (128, 256), (512, 1024)] {
        let mut nodes = Vec::new();
        for j in 0..=nz {
            for i in 0..=nr {
                nodes.push(Node {
                    r: i as f64 * 1e-4,
                    z: j as f64 * 1e-4,
                    v_r: 0.01 * i as f64,
                    v_z: 1.0 - 0.02 * j as f64,
                });
            }
        }
        let id = |i: usize, j: usize| (j * (nr + 1) + i) as u32;
        let mut el = Vec::new();
        for j in 0..nz {
            for i in 0..nr {
                el.push([id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
        let c = Constants {
            bulk: 130e9,
            shear: 43e9,
            hourglass_stiffness: 0.005,
            hourglass_viscosity: 0.0,
            bulk_viscosity: [0.06, 1.2],
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| {
            let mut q = Quads::new(Lines::new(&[[400e6, 0.0], [900e6, 5.0]], 43e9).unwrap(), c, 8930.0, &el, &nodes);
            let mut corners = vec![[[0.0; LANES]; 8]; el.len().div_ceil(LANES)];
            let reps = (20_000_000 / el.len()).max(3);
            let mut best = f64::INFINITY;
            for _ in 0..5 {
                let t = Instant::now();
                for _ in 0..reps {
                    q.update(&nodes, 1e-9, &mut corners);
                }
                best = best.min(t.elapsed().as_secs_f64() / reps as f64 / el.len() as f64 * 1e9);
            }
            println!("{} elements: {best:.2} ns", el.len());
        });
    }
}
