//! A model composed in Rust, without a deck: a steel bar, fixed at one end, with a pressure from a closure at the other. Prints
//! the displacement of that end, the closed form of the wave equation, and the ledger. `cargo run --release --example scene_in_rust`.

use std::error::Error;
use std::f64::consts::TAU;

use revolve::job;
use revolve::model::{
    BoundaryCondition, ElementKind, ElementSide, Load, MaterialDefinition, Model, OutputRegion, OutputRequest,
    SideSelection, Step,
};
use revolve::user::Routines;
use revolve::variables::{Variable, VariableComponent};

const DENSITY: f64 = 7850.0;
const MODULUS: f64 = 210e9;
const LENGTH: f64 = 0.5;
const PEAK: f64 = 1e8;

/// Returns the bar: one element over the radius, `count` along z. Poisson's ratio is 0, so that waves are plane.
fn bar(count: usize, duration: f64) -> Model {
    let mut model = Model::default();
    let rows: Vec<[usize; 2]> =
        (0..=count).map(|j| [0.0, 0.01].map(|r| model.node(r, LENGTH * j as f64 / count as f64))).collect();
    let elements: Vec<usize> =
        rows.windows(2).map(|w| model.element(ElementKind::Cax4r, &[w[0][0], w[0][1], w[1][1], w[1][0]])).collect();
    let steel = model.material(MaterialDefinition::elastic("STEEL", DENSITY, MODULUS, 0.0));
    model.section(&elements, steel);
    let tip = model.node_set("TIP", &rows[count][..1]);
    let top = SideSelection::new("TOP", &[(elements[count - 1], ElementSide::Face(3))]);
    let axial = VariableComponent { variable: Variable::Displacement, component: 1 };
    model.steps.push(
        Step::new("push", duration)
            .with_boundary(BoundaryCondition::fixed("FOOT", &rows[0], 2))
            .with_load(Load::user(top))
            .with_output(OutputRequest::history(OutputRegion::Nodes(tip), [axial])),
    );
    model
}

fn main() -> Result<(), Box<dyn Error>> {
    let speed = (MODULUS / DENSITY).sqrt();
    let duration = LENGTH / speed;
    // One smooth pulse that ends when the wave reaches the foot: until then u = -integral of p/(rho c).
    let pulse = move |time: f64| 0.5 * PEAK * (1.0 - (TAU * time / duration).cos());
    let routines = Routines::none().with_pressure(move |points, _| pulse(points.now.total_time));
    let prepared = job::prepare_model(&bar(100, duration), &routines);
    let history = job::run_to_end(&prepared)?;
    let exact = -0.5 * PEAK * duration / (DENSITY * speed);
    println!("displacement of the tip: {:.6e} m, closed form {exact:.6e} m", history.0["U2@TIP"].last);
    print!("{}", prepared.plan.ledger.render(false));
    Ok(())
}
