mod common;
use revolve::deck::{Deck, Span};
use revolve::model::*;
use revolve::{plan, solve};

fn ogive(n: usize, v: f64, front: f64, dt: IncrementControl) -> Model {
    let a: f64 = 3.555e-3;
    let big = 6.0 * a;
    let l = 11f64.sqrt() * a;
    let t0 = (l / big).asin();
    let mut m = Model::default();
    for i in 0..=n {
        let t = -t0 + t0 * (i as f64) / (n as f64);
        m.mesh.points.push([a - big + big * t.cos(), l + big * t.sin()]);
        m.mesh.node_names.push(i.to_string());
    }
    m.mesh.points[0][0] = 0.0;
    m.mesh.points[0][1] = 0.0;
    m.mesh.points.push([0.0, 0.05]);
    m.mesh.node_names.push("ref".into());
    for i in 0..n {
        m.mesh.elements.push(Element {
            name: i.to_string(),
            kind: ElementKind::Rax2,
            nodes: vec![i, i + 1],
            span: Span::default(),
        });
    }
    m.rigid_bodies.push(RigidBody {
        name: "P".into(),
        reference: n + 1,
        elements: (0..n).collect(),
        nodes: vec![],
        thickness: 0.0,
        density: 0.0,
        span: Span::default(),
    });
    m.point_masses.push(PointMass { node: n + 1, mass: 0.021, span: Span::default() });
    m.materials.push(Material {
        name: "AL".into(),
        density: Some(2710.0),
        cavity: Some(CavityExpansion { yield_stress: 276e6, a: 5.0394, b: 0.0, c: 0.9830, span: Span::default() }),
        ..Default::default()
    });
    m.targets.push(Target {
        name: "B".into(),
        front,
        direction: -1.0,
        layers: vec![Layer { material: 0, thickness: 5.0, span: Span::default() }],
        span: Span::default(),
    });
    m.initial_conditions.push(InitialCondition {
        kind: InitialKind::Velocity(2, -v),
        members: vec![n + 1],
        span: Span::default(),
    });
    let sides = Sides { name: "NOSE".into(), surface: true, faces: (0..n).map(|i| (i, Side::Negative)).collect() };
    m.steps.push(Step {
        name: "s".into(),
        span: Span::default(),
        duration: 1e-3,
        increment: dt,
        scale_factor: 1.0,
        load_velocity: LoadVelocity::Predicted,
        bulk_viscosity: [0.06, 1.2],
        boundaries: vec![],
        loads: vec![Load {
            kind: LoadKind::Cavity { sides, target: 0, friction: 0.0 },
            magnitude: 1.0,
            amplitude: None,
            span: Span::default(),
        }],
        outputs: vec![],
    });
    m
}
#[test]
fn quick() {
    for (n, acc) in [(20, 1e-4), (400, 1e-4), (400, 1e-6), (400, 1e-8)] {
        for (v, front, exact) in [
            (569.0, 1.0, 59.612643939e-3),
            (1147.0, 1.0, 221.597433967e-3),
            (569.0, 0.0, 64.8475307e-3),
            (1147.0, 0.0, 226.5690103e-3),
        ] {
            let m = ogive(n, v, front, IncrementControl::Automatic { accuracy: acc, element_by_element: false });
            let (mut p, d) = plan::compile(&Deck::default(), &m, None);
            for x in d.iter() {
                println!("{x:?}")
            }
            let mut mem = common::Memory::default();
            let o = solve::run(&mut p, &mut mem);
            println!(
                "{n} {acc:e} {v} {front}: inc {} rest {:?} err {:.3e} drift {:.2e} {:?} {:.1} us",
                o.increments,
                o.rests.first().map(|r| (r.time, r.displacement)),
                -o.rests[0].displacement / exact - 1.0,
                o.energy.drift,
                o.halt,
                o.seconds * 1e6
            );
        }
    }
}
