//! Models built in Rust: they give the bits of the corresponding decks, and their errors have the codes of the deck
//! errors.

use revolve::job::{self, PreparedJob};
use revolve::model::{
    Amplitude, AmplitudeDefinition, AmplitudeId, BoundaryCondition, ElementKind, ElementSide, Load, LoadKind,
    MaterialDefinition, MaterialId, Model, NodeSetId, OutputInterval, OutputRegion, OutputRequest, RotaryInertia,
    SideSelection, Step, TargetId,
};
use revolve::user::Routines;
use revolve::variables::{Variable, VariableComponent};

use crate::common::{prepared, run};

const DECK: &str = "
*Node, nset=ALL
 1, 0., 0.
 2, 0.01, 0.
 3, 0.01, 0.01
 4, 0., 0.01
*Element, type=CAX4R, elset=SOLID
 1, 1, 2, 3, 4
*Nset, nset=FOOT
 1, 2
*Nset, nset=TIP
 4
*Surface, name=TOP
 SOLID, S3
*Material, name=STEEL
*Density
 7850.,
*Elastic
 210.e9, 0.3
*Solid Section, elset=SOLID, material=STEEL
*Step
*Dynamic, Explicit
 , 1.e-5
*Boundary
 FOOT, 2
*Dsload
 TOP, P, 1.e8
*Output, history
*Node Output, nset=TIP
 U2
*End Step
";

/// Returns the model of the deck, built in Rust.
fn composed() -> Model {
    let mut model = Model::default();
    let nodes = [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]].map(|[r, z]| model.node(r, z));
    let element = model.element(ElementKind::Cax4r, &nodes);
    let steel = model.material(MaterialDefinition::elastic("STEEL", 7850.0, 210e9, 0.3));
    model.section(&[element], steel);
    let tip = model.node_set("TIP", &nodes[3..]);
    let axial = VariableComponent { variable: Variable::Displacement, component: 1 };
    let step = Step::new("push", 1e-5)
        .with_boundary(BoundaryCondition::fixed("FOOT", &nodes[..2], 2))
        .with_load(Load::pressure(SideSelection::new("TOP", &[(element, ElementSide::Face(3))]), 1e8))
        .with_output(OutputRequest::history(OutputRegion::Nodes(tip), [axial]));
    model.steps.push(step);
    model
}

fn planned(model: &Model) -> PreparedJob {
    job::prepare_model(model, &Routines::none())
}

#[test]
fn model_built_in_rust_matches_the_deck() {
    let scene = planned(&composed());
    assert!(!scene.diagnostics.has_errors(), "{}", scene.diagnostics.render(&scene.deck.sources));
    let (outcome, history) = job::run_in_memory(&scene);
    let (of_deck, memory) = run(DECK, &[], &Routines::none());
    assert_eq!(outcome.digest, of_deck.digest);
    assert_eq!(history.0["U2@TIP"].last, memory.rows.last().expect("a row").1[0]);
    let rows = |p: &PreparedJob| p.plan.ledger.effects.iter().map(|r| (r.effect.clone(), r.count)).collect::<Vec<_>>();
    assert_eq!(rows(&scene), rows(&prepared(DECK, &[], &Routines::none())));
    let requested =
        |r: &revolve::plan::ledger::LedgerRow| r.asked_by.iter().all(|place| place.starts_with("composed in Rust"));
    assert!(scene.plan.ledger.effects.iter().all(requested), "{}", scene.plan.ledger.render(true));
}

/// The identity of a model depends on all its contents and on nothing else.
#[test]
fn checkpoint_fits_its_own_model_only() {
    let identity = |model: &Model| planned(model).identity("");
    assert_eq!(identity(&composed()), identity(&composed()));
    let mut other = composed();
    other.materials[0].density = Some(7851.0);
    assert_ne!(identity(&composed()), identity(&other));
}

#[test]
fn invalid_models_are_rejected_without_panic() {
    type InvalidModel = (&'static str, fn(&mut Model));
    let cases: &[InvalidModel] = &[
        ("M126", |m| m.mesh.points[1][0] = f64::NAN),
        ("M126", |m| m.mesh.points[1][0] = -1.0),
        ("M110", |m| drop(m.mesh.node_names.pop())),
        ("M122", |m| m.mesh.elements[0].nodes[2] = 9),
        ("M122", |m| m.mesh.elements[0].nodes.truncate(3)),
        ("P012", |m| m.mesh.elements[0].nodes.reverse()),
        ("P001", |m| m.sections.clear()),
        ("M110", |m| m.sections[0].elements.push(7)),
        ("M111", |m| m.sections[0].material = MaterialId::new(3)),
        ("M103", |m| m.materials[0].density = Some(-1.0)),
        ("P013", |m| m.materials[0].density = None),
        ("M103", |m| m.materials[0].elastic = Some([210e9, 0.5])),
        ("M103", |m| m.materials[0].elastic = Some([f64::INFINITY, 0.3])),
        ("M103", |m| m.steps[0].duration = 0.0),
        ("M103", |m| m.steps[0].scale_factor = f64::NAN),
        ("M110", |m| m.steps[0].boundaries[0].nodes.push(99)),
        ("M103", |m| m.steps[0].boundaries[0].dof = 0),
        ("M112", |m| m.steps[0].boundaries[0].amplitude = Some(AmplitudeId::new(0))),
        ("M103", |m| m.steps[0].loads[0].magnitude = f64::INFINITY),
        ("M131", |m| {
            m.steps[0].loads[0].kind = LoadKind::Pressure(SideSelection::new("TOP", &[(0, ElementSide::Face(5))]))
        }),
        ("M110", |m| {
            m.steps[0].loads[0].kind = LoadKind::Pressure(SideSelection::new("TOP", &[(4, ElementSide::Face(1))]))
        }),
        ("P004", |m| m.steps[0].loads.push(Load::user(SideSelection::new("TOP", &[(0, ElementSide::Face(3))])))),
        ("M113", |m| {
            let sides = SideSelection::new("TOP", &[(0, ElementSide::Face(3))]);
            m.steps[0].loads.push(Load::new(LoadKind::Cavity { sides, target: TargetId::new(0), friction: 0.0 }, 1.0));
        }),
        ("M103", |m| {
            let definition = AmplitudeDefinition::Curve { points: Vec::new(), smooth: false, total_time: false };
            m.amplitudes.push(Amplitude { name: "A".into(), definition, absolute: false, span: Default::default() });
        }),
        ("M110", |m| drop(m.node_sets.shift_remove("TIP"))),
        ("M141", |m| {
            let part = VariableComponent { variable: Variable::Displacement, component: 2 };
            m.steps[0].outputs.push(OutputRequest::history(OutputRegion::Nodes(NodeSetId::new(0)), [part]));
        }),
        ("M103", |m| m.steps[0].outputs[0].interval = OutputInterval::Time(0.0)),
        ("P006", |m| m.steps.clear()),
        ("M110", |m| m.mass(17, 1.0)),
        ("P005", |m| {
            let node = m.node(0.0, 1.0);
            m.discrete.inertias.push(RotaryInertia { node, moments: [1.0; 3], span: Default::default() });
        }),
        ("M103", |m| m.initial_velocity(&[0], 2, f64::NAN)),
    ];
    for (i, (code, spoil)) in cases.iter().enumerate() {
        let mut model = composed();
        spoil(&mut model);
        let found = planned(&model).diagnostics;
        let text = found.render(&Default::default());
        assert!(found.has_errors() && found.iter().any(|d| d.code == *code), "case {i}, {code}: {text}");
    }
}
