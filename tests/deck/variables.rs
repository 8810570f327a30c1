//! Output variables of the variable table.
//!
//! Goal: every variable of the table can be requested and has its labels in histories and frames; `explain`, the page
//! of variables and the messages agree with the table; POSITION puts variables of integration points on nodes. Source:
//! Abaqus Analysis User's Guide, "Writing element output to the output database" (positions).

use std::collections::BTreeSet;

use crate::common::solid::{grid, material};
use crate::common::{RecordedOutput, ogive, prepared};
use revolve::explain::explain;
use revolve::job;
use revolve::output::{FieldArray, OutputFrame};
use revolve::user::{LoadFailure, MaterialAnswer, MaterialCall, Routines, UserMaterial};
use revolve::variables::manual::variable_manual;
use revolve::variables::request::NOT_SIMULATED;
use revolve::variables::{PreselectRule, Variable, VariableComponent, VariablePlace};

/// Returns a block of 2 by 2 elements that flies against its fixed foot, with sets ONE (an element) and TIP (a node).
fn block(material: &str, requests: &str) -> String {
    grid(2, 2, false, |i, j| [1.0 + i as f64, j as f64])
        + material
        + "*Elset, elset=ONE\n 1,\n*Nset, nset=TIP\n 9,\n*Initial Conditions, type=VELOCITY\n ALL, 2, -1.\n\
           *Step\n*Dynamic, Explicit\n , 0.05\n*Boundary\n J0, 2, 2\n"
        + requests
        + "*End Step\n"
}

/// Returns plastic steel with heat from plastic work.
fn steel() -> String {
    material(
        1000.0,
        0.3,
        2.0,
        "*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 10.,\n*Plastic, hardening=JOHNSON COOK\n \
         1., 1., 0.5, 1., 1500., 20.\n*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n",
    )
}

/// Returns whether a variable exists only in contact.
fn is_of_contact(variable: Variable) -> bool {
    variable.is_of_contact_nodes() || variable.place() == VariablePlace::Pair
}

/// Adds a rigid lid that falls on the block.
fn pressed(deck: &str) -> String {
    let lid = "*Node, nset=LIDS\n 101, 1., 2.\n 102, 3., 2.\n 103, 3., 3.\n 104, 1., 3.\n*Element, type=CAX4R, elset=LID\n \
               101, 101, 102, 103, 104\n*Surface, name=LID\n LID, S1\n*Solid Section, elset=LID, material=M\n\
               *Initial Conditions, type=VELOCITY\n LIDS, 2, -3.\n";
    deck.replacen("*Step\n", &format!("{lid}*Step\n"), 1)
        .replace("*Boundary\n J0, 2, 2\n", "*Boundary\n J0, 2, 2\n*Contact Pair\n J1, LID\n")
}

/// Returns the criterion of damage initiation with which a variable of cohesive elements exists.
fn criterion_with(variable: Variable) -> Option<&'static str> {
    match variable {
        Variable::NominalStrain | Variable::QuadraticStressInitiation => Some("QUADS"),
        Variable::LargestStressInitiation => Some("MAXS"),
        Variable::QuadraticStrainInitiation => Some("QUADE"),
        Variable::LargestStrainInitiation => Some("MAXE"),
        _ => None,
    }
}

/// Returns a deck of one cohesive element whose faces move apart.
fn separated(criterion: &str, requests: &str) -> String {
    let strains = if criterion.ends_with('E') { "0.01, 0.015" } else { "5., 6." };
    format!(
        "*Node\n 1, 1., 0.\n 2, 2., 0.\n 3, 2., 0.\n 4, 1., 0.\n*Nset, nset=TOP\n 3, 4\n*Element, type=COHAX4, elset=ONE\n \
         1, 1, 2, 3, 4\n*Cohesive Section, elset=ONE, material=M, response=TRACTION SEPARATION\n*Material, \
         name=M\n*Density\n 1.,\n*Elastic, type=TRACTION\n 500., 400.\n*Damage Initiation, criterion={criterion}\n \
         {strains}\n*Damage Evolution, type=ENERGY\n 0.2,\n*Step\n*Dynamic, Explicit\n , 0.05\n*Boundary, \
         type=VELOCITY\n TOP, 2, 2, 0.1\n{requests}*End Step\n"
    )
}

/// Returns the criterion of damage initiation with which a variable of cohesive surfaces exists.
fn surface_criterion_with(variable: Variable) -> Option<&'static str> {
    match variable {
        Variable::SurfaceDamage | Variable::QuadraticTractionInitiation => Some("QUADS\n 5., 6."),
        Variable::LargestTractionInitiation => Some("MAXS\n 5., 6."),
        Variable::QuadraticSeparationInitiation => Some("QUADU\n 0.01, 0.015"),
        Variable::LargestSeparationInitiation => Some("MAXU\n 0.01, 0.015"),
        _ => None,
    }
}

/// Returns a deck in which a variable exists: the block, or a ring of shells with the same motion.
fn scene(variable: Variable, requests: &str) -> String {
    if let Some(criterion) = criterion_with(variable) {
        return separated(criterion, requests);
    }
    let solid = block_with(variable, requests);
    if variable.row().preselected == PreselectRule::MassScaling || variable == Variable::MassScalingFactor {
        return solid.replacen("*Boundary\n", "*Fixed Mass Scaling, factor=1.01\n*Boundary\n", 1);
    }
    if variable.row().preselected == PreselectRule::AdaptiveMesh {
        return solid.replacen("*Boundary\n", "*Adaptive Mesh, elset=SOLID\n*Boundary\n", 1);
    }
    if variable.row().preselected == PreselectRule::EulerianBoundary {
        let held = "*Adaptive Mesh, elset=SOLID\n*Adaptive Mesh Constraint\n J1, 2, 2\n*Boundary\n";
        let open = "*Surface, name=J1, region type=EULERIAN\n";
        return solid.replacen("*Boundary\n", held, 1).replacen("*Surface, name=J1\n", open, 1);
    }
    if variable.row().preselected == PreselectRule::PenaltyContact {
        return pressed(&solid).replace("*Contact Pair", "*Contact Pair, mechanical constraint=PENALTY");
    }
    if let Some(criterion) = surface_criterion_with(variable) {
        let bond = format!(
            "*Surface Interaction, name=BOND\n*Cohesive Behavior\n 500., 400.\n*Damage Initiation, criterion={criterion}\n\
             *Damage Evolution, type=ENERGY\n 0.2,\n*Step\n"
        );
        let solid = pressed(&solid).replacen("*Step\n", &bond, 1);
        return solid.replace("*Contact Pair", "*Contact Pair, interaction=BOND");
    }
    if is_of_contact(variable) {
        return pressed(&solid);
    }
    let Some((_, rest)) =
        solid.split_once("*Solid Section, elset=SOLID, material=M").filter(|_| variable.is_of_shells())
    else {
        return solid;
    };
    let shell = "*Node, nset=ALL\n 1, 1., 0.\n 9, 2., 0.\n*Element, type=SAX1, elset=SOLID\n 1, 1, 9\n*Nset, nset=J0\n 1,\n\
                 *Shell Section, elset=SOLID, material=M\n 0.1";
    shell.to_owned() + rest
}

fn gas() -> String {
    "*Solid Section, elset=SOLID, material=GAS\n*Material, name=GAS\n*Density\n 1.,\n*Eos, type=IDEAL GAS\n 0.4, 0.\n\
     *Specific Heat\n 1.,\n*Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 10.\n"
        .into()
}

/// Linear elastic user material; stores the density and a constant.
struct ElasticMaterial;

impl UserMaterial for ElasticMaterial {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        for i in 0..n {
            let strain = [0, 1, 2, 3].map(|k| call.strain[k * n + i]);
            let dilation = strain[0] + strain[1] + strain[2];
            for (k, part) in strain.into_iter().enumerate() {
                let bulk = if k < 3 { 100.0 * dilation } else { 0.0 };
                answer.stress[k * n + i] = call.stress[k * n + i] + bulk + 200.0 * part;
            }
            (answer.state[i], answer.state[n + i]) = (call.density[i], 7.0);
        }
        Ok(())
    }
}

fn kept() -> String {
    "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n*User Material, constants=1\n 1.,\n*Depvar\n 2,\n".into()
}

/// Returns whether a variable exists only with heat conduction.
fn is_of_conduction(variable: Variable) -> bool {
    variable.row().preselected == PreselectRule::HeatConduction
}

/// Returns a block in which a variable exists.
fn block_with(variable: Variable, requests: &str) -> String {
    let text = block(&material_with(variable), requests);
    if !is_of_conduction(variable) {
        return text;
    }
    text.replace("CAX4R", "CAX4RT")
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
        .replace("*Specific Heat", "*Conductivity\n 1.,\n*Specific Heat")
}

fn damaged() -> String {
    let ductile =
        "*Damage Initiation, criterion=DUCTILE\n 0.5, 0.\n 0.4, 1.\n*Damage Evolution, type=DISPLACEMENT\n 0.1,\n";
    let johnson_cook = "*Damage Initiation, criterion=JOHNSON COOK\n 0.5, 0., 0., 0., 0., 0., 0., 1.\n\
                        *Damage Evolution, type=DISPLACEMENT\n 0.1,\n";
    steel().replace("*Initial Conditions", &format!("{ductile}{johnson_cook}*Initial Conditions"))
}

fn explosive() -> String {
    "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n*Eos, type=JWL\n 5., 10., 1., 0.3, 4., 1., 1.\n\
     *Detonation Point\n 1., 0.\n"
        .into()
}

/// Returns a material with these cards.
fn strong(cards: &str) -> String {
    format!("*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n{cards}")
}

/// Returns the material of a block whose elements have a variable.
fn material_with(variable: Variable) -> String {
    match variable {
        Variable::State => kept(),
        Variable::SpecificEnergy => gas(),
        v if v.place() == VariablePlace::Energy && v.row().preselected == PreselectRule::ElementDeletion => damaged(),
        Variable::Degradation
        | Variable::DamageInitiation
        | Variable::DuctileInitiation
        | Variable::JohnsonCookInitiation
        | Variable::ElementDamageEnergy
        | Variable::AllDamageEnergy => damaged(),
        Variable::BurnFraction => explosive(),
        Variable::Damage | Variable::PlasticCompaction => strong(
            "*Holmquist Johnson Cook\n 400., 0.8, 1.6, 0., 0.6, 2., 0.2, 1.\n 0.01, 7., 0.5, 5e-4, 25., 0.1, 0.04, 1.\n 1e3, 0., \
             0., 0.\n",
        ),
        Variable::TensionDamage | Variable::CompressionDamage | Variable::TensionPlasticStrain => strong(
            "*Elastic\n 1e3, 0.3\n*Concrete Damaged Plasticity\n 30.,\n*Concrete Compression Hardening\n 2., 0.\n 2., 0.1\n\
             *Concrete Tension Stiffening\n 0.2, 0.\n 0.02, 0.1\n",
        ),
        Variable::CapStrain => {
            strong("*Elastic\n 1e3, 0.3\n*Cap Plasticity\n 1., 30., 0.5\n*Cap Hardening\n 2., 0.\n 9., 0.1\n")
        }
        Variable::VoidVolumeFraction | Variable::RelativeDensity => strong(
            "*Elastic\n 1e3, 0.3\n*Plastic\n 1., 0.\n*Porous Metal Plasticity, relative density=0.98\n 1.5, 1., 2.25\n",
        ),
        Variable::Distension => strong("*Eos, type=USUP\n 22., 1.3, 2.\n*Eos Compaction\n 15., 0.2, 0.5, 9.\n"),
        _ => steel(),
    }
}

fn run(deck: &str) -> (Vec<String>, RecordedOutput) {
    let routines = Routines::none().with_material(ElasticMaterial);
    let columns = prepared(deck, &[], &routines).plan.columns.iter().map(|c| c.name.clone()).collect();
    let (outcome, memory) = crate::common::run(deck, &[], &routines);
    assert_eq!(outcome.halt, None, "{deck}");
    (columns, memory)
}

/// Returns the labels of a variable in these decks; the user material has two state variables.
fn labels(variable: Variable) -> Vec<String> {
    let numbers = if variable.row().numbered { 2 } else { variable.parts().count() };
    (0..numbers).map(|component| VariableComponent { variable, component }.label()).collect()
}

/// Returns a history request for a variable, and the part of the column names after the variable.
fn history(variable: Variable, name: &str) -> (String, &'static str) {
    let (card, place) = match variable.place() {
        VariablePlace::Node => ("*Node Output, nset=TIP", "@TIP"),
        VariablePlace::Point | VariablePlace::Element => ("*Element Output, elset=ONE", "@ONE"),
        VariablePlace::Energy => ("*Energy Output", ""),
        VariablePlace::Part => ("*Energy Output, elset=ONE", "@ONE"),
        VariablePlace::Increment => ("*Incrementation Output", ""),
        VariablePlace::Pair => ("*Contact Output", "@J1_LID"),
        VariablePlace::Section => ("*Integrated Output, surface=J0", "@J0"),
        VariablePlace::Facet => unreachable!("facets have no histories"),
    };
    (format!("*Output, history, number interval=2\n{card}\n {name}\n"), place)
}

#[test]
fn every_variable_except_facet_ones_is_a_history_with_its_labels() {
    for &variable in Variable::ALL.iter().filter(|v| v.place() != VariablePlace::Facet && !is_of_oblique_bodies(**v)) {
        let all = labels(variable);
        let whole = [(variable.name().to_owned(), all.clone())];
        for (name, expected) in whole.into_iter().chain(all.into_iter().map(|l| (l.clone(), vec![l]))) {
            let (request, place) = history(variable, &name);
            let (columns, memory) = run(&scene(variable, &request));
            let expected: Vec<String> = expected.iter().map(|l| format!("{l}{place}")).collect();
            assert_eq!(columns, expected, "{name}");
            let values = memory.rows.iter().flat_map(|row| &row.1);
            assert!(values.clone().all(|v| v.is_finite()), "{name}: {:?}", memory.rows);
        }
    }
}

#[test]
fn a_rigid_body_has_the_histories_of_a_node() {
    let plain = |v: &&Variable| {
        let others = is_of_conduction(**v) || v.is_of_shells() || is_of_contact(**v) || is_of_oblique_bodies(**v);
        v.place() == VariablePlace::Node && !others
    };
    for &variable in Variable::ALL.iter().filter(plain) {
        let request = format!("*Output, history\n*Node Output, nset=REF\n {}\n*End Step", variable.name());
        let (columns, _) = run(&ogive().replace("*End Step", &request));
        for label in labels(variable) {
            assert!(columns.contains(&format!("{label}@REF")), "{label}: {columns:?}");
        }
    }
}

fn is_of_oblique_bodies(variable: Variable) -> bool {
    variable.row().preselected == PreselectRule::SixDofBody
}

/// A rigid body with six degrees of freedom has components along and about three axes, requested by variable name or by
/// label.
#[test]
fn oblique_body_has_three_dimensional_histories() {
    let deck = std::fs::read_to_string(crate::common::project("input/oblique.inp")).expect("a deck");
    let short = deck.replace(" , 4.e-4", " , 1.e-6").replace("stations  = 64", "stations = 4");
    let head = short.split("*Output, field").next().expect("a step");
    let three = |name: &str| [1, 2, 3].map(|i| format!("{name}{i}@REF")).to_vec();
    let mut requested: Vec<(String, Vec<String>)> =
        ["U", "V", "A", "UR", "VR", "AR"].map(|name| (name.to_owned(), three(name))).to_vec();
    for &variable in Variable::ALL.iter().filter(|v| is_of_oblique_bodies(**v)) {
        requested.extend(labels(variable).into_iter().map(|label| (label.clone(), vec![format!("{label}@REF")])));
    }
    for (name, mut expected) in requested {
        let (mut columns, memory) =
            run(&format!("{head}*Output, history\n*Node Output, nset=REF\n {name}\n*End Step\n"));
        columns.sort();
        expected.sort();
        assert_eq!(columns, expected, "{name}");
        assert!(memory.rows.iter().flat_map(|row| &row.1).all(|v| v.is_finite()), "{name}");
    }
}

fn field<'a>(fields: &'a [FieldArray], name: &str) -> Option<&'a FieldArray> {
    fields.iter().find(|f| f.name == name)
}

#[test]
fn every_variable_of_nodes_and_elements_is_a_field_with_its_labels() {
    let in_frames = |v: &&Variable| (v.is_of_nodes() || v.is_of_elements()) && !is_of_oblique_bodies(**v);
    for &variable in Variable::ALL.iter().filter(in_frames) {
        let card = if variable.is_of_nodes() { "*Node Output" } else { "*Element Output" };
        let request = format!("*Output, field, number interval=1\n{card}\n {}\n", variable.name());
        let (_, memory) = run(&scene(variable, &request));
        let frame = memory.frames.last().expect("a frame");
        let fields = if variable.is_of_nodes() { &frame.point_fields } else { &frame.cell_fields };
        let all = labels(variable);
        match variable {
            // Coordinates are the points of the frame.
            Variable::Coordinate => assert!(fields.is_empty()),
            Variable::State => assert!(all.iter().all(|l| field(fields, l).is_some_and(|f| f.components == 1))),
            _ => {
                // A field with one component is named by its label.
                let name = if let [only] = &all[..] { only } else { variable.name() };
                let shown = field(fields, name).expect("a field of its name");
                assert_eq!(shown.components, all.len());
                assert!(all.len() == 1 || shown.component_names == all, "{:?}", shown.component_names);
                // The contact opening is finite only near another surface.
                let near = |v: &f64| v.is_finite() || variable == Variable::ContactOpening;
                assert!(shown.values.iter().all(near) && shown.values.iter().any(|v| v.is_finite()), "{}", shown.name);
            }
        }
        let count = frame.point_fields.len() + frame.cell_fields.len();
        assert_eq!(
            count,
            if variable == Variable::Coordinate {
                0
            } else if variable == Variable::State {
                2
            } else {
                1
            }
        );
    }
}

#[test]
fn every_variable_of_facets_is_in_the_frames_of_a_loaded_surface() {
    let (_, memory) = run(&ogive());
    let names: Vec<&str> = memory.frames[0].cell_fields.iter().map(|f| f.name.as_str()).collect();
    let facets = Variable::ALL.iter().filter(|v| v.place() == VariablePlace::Facet);
    assert_eq!(names, facets.map(|v| v.name()).collect::<Vec<_>>());
}

/// Default columns and their order.
#[test]
fn default_output_matches_the_table() {
    let fields = |frame: &OutputFrame| {
        let all = frame.point_fields.iter().chain(&frame.cell_fields);
        all.map(|f| f.name.clone()).collect::<Vec<_>>()
    };
    let (columns, memory) = run(&block(&steel(), ""));
    assert_eq!(fields(&memory.frames[0]), ["U", "V", "A", "RF", "S", "MISES", "PRESS", "PEEQ", "LE", "PE"]);
    let energies =
        ["ALLKE", "ALLWK", "ALLFD", "ALLCAV", "ALLIE", "ALLSE", "ALLPD", "ALLVD", "ALLAE", "ALLCW", "ALLDC", "ETOTAL"];
    assert_eq!(columns, energies);
    let (_, memory) = run(&block(&material(1000.0, 0.3, 2.0, ""), "*Output, field, variable=PRESELECT\n"));
    assert_eq!(fields(&memory.frames[0]), ["U", "V", "A", "RF", "S", "MISES", "PRESS", "LE"]);
}

#[test]
fn all_and_preselect_select_variables_of_their_card() {
    let names = |card: &str| {
        let (columns, memory) = run(&block(&steel(), card));
        let fields = memory.frames.first().map(|f| f.point_fields.iter().chain(&f.cell_fields).map(|f| f.name.clone()));
        (columns, fields.map(Iterator::collect::<Vec<_>>).unwrap_or_default())
    };
    assert_eq!(names("*Output, history\n*Incrementation Output, variable=ALL\n").0, ["DT"]);
    let nodes = names("*Output, history\n*Node Output, nset=TIP, variable=ALL\n").0;
    assert_eq!(nodes.join(" "), "U1@TIP U2@TIP V1@TIP V2@TIP A1@TIP A2@TIP RF1@TIP RF2@TIP COOR1@TIP COOR2@TIP");
    assert_eq!(names("*Output, field\n*Node Output, variable=ALL\n").1, ["U", "V", "A", "RF"]);
    assert_eq!(
        names("*Output, field\n*Element Output, variable=PRESELECT\n").1,
        ["S", "MISES", "PRESS", "PEEQ", "LE", "PE"]
    );
    let elements = names("*Output, field\n*Element Output, variable=ALL\n").1;
    let expected = "S MISES PRESS SP TRESC TRIAX PEEQ TEMP LE LEP PE PEP PEMAG ER ERP ERV SENER PENER STATUS EVOL DENSITY ELSE ELPD ELASE MASS";
    assert_eq!(elements.join(" "), expected);
}

/// An element with one integration point extrapolates its value to all corners; a node has the mean over its elements.
#[test]
fn nodal_positions_average_adjacent_elements() {
    for position in ["NODES", "averaged at nodes"] {
        let request = format!(
            "*Output, field, number interval=3\n*Element Output\n S\n*Element Output, position={position}\n S, EVOL\n"
        );
        let (_, memory) = run(&block(&steel(), &request));
        let frame = memory.frames.last().expect("a frame");
        let (cells, points) = (field(&frame.cell_fields, "S").expect("S"), field(&frame.point_fields, "S").expect("S"));
        assert_eq!(points.component_names, cells.component_names);
        let around: [&[usize]; 9] = [&[0], &[0, 1], &[1], &[0, 2], &[0, 1, 2, 3], &[1, 3], &[2], &[2, 3], &[3]];
        for (node, elements) in around.iter().enumerate() {
            for c in 0..4 {
                let mean = elements.iter().map(|e| cells.values[4 * e + c]).sum::<f64>() / elements.len() as f64;
                assert!((points.values[4 * node + c] - mean).abs() <= 1e-14 * mean.abs(), "node {node}");
            }
        }
        // A variable of whole elements, not of integration points.
        assert!(field(&frame.cell_fields, "EVOL").is_some() && field(&frame.point_fields, "EVOL").is_none());
    }
    let cells =
        "*Output, field\n*Element Output, position=CENTROIDAL\n S\n*Element Output, position=integration points\n S\n";
    let (_, memory) = run(&block(&steel(), cells));
    assert_eq!((memory.frames[0].cell_fields.len(), memory.frames[0].point_fields.len()), (1, 0));
}

/// Deleted elements do not contribute to a mean. A node has no value if all its elements are deleted, or on a rigid
/// body.
#[test]
fn nodal_positions_ignore_deleted_elements() {
    let rigid = "*Node, nset=REF\n 90, 0., 9.\n*Node\n 91, 1., 9.\n*Element, type=RAX2, elset=WALL\n 90, 90, 91\n\
                 *Rigid Body, ref node=REF, elset=WALL\n*Element, type=MASS, elset=M\n 92, 90\n*Mass, elset=M\n 1.,\n";
    let request = "*Output, field, number interval=20\n*Element Output\n MISES, STATUS\n*Element Output, position=NODES\n MISES\n";
    let fragile = steel().replace("*Initial", "*Shear Failure\n 0.03,\n*Initial") + rigid;
    let (_, memory) = run(&block(&fragile, request));
    let (mut partly, mut nowhere) = (0, 0);
    for frame in &memory.frames {
        let [mises, status] = ["MISES", "STATUS"].map(|n| &field(&frame.cell_fields, n).expect(n).values);
        let points = &field(&frame.point_fields, "MISES").expect("MISES").values;
        for (node, value) in points.iter().enumerate() {
            let around = (0..frame.cells.len()).filter(|c| frame.cells[*c].contains(&(node as u32)));
            let all: Vec<usize> = around.collect();
            let there: Vec<usize> = all.iter().copied().filter(|c| status[*c] == 1.0).collect();
            let mean = there.iter().map(|e| mises[*e]).sum::<f64>() / there.len() as f64;
            partly += usize::from(!there.is_empty() && there.len() < all.len());
            nowhere += usize::from(there.is_empty() && all.iter().any(|c| status[*c] == 0.0));
            assert!(value.is_nan() && mean.is_nan() || (value - mean).abs() <= 1e-14 * mean, "{node}: {value} {mean}");
        }
    }
    assert!(partly > 0 && nowhere > 0, "elements are deleted: {partly} {nowhere}");
    assert!(
        field(&memory.frames[0].point_fields, "MISES").is_some_and(|f| f.values[9].is_nan() && f.values[10].is_nan())
    );
}

/// Returns errors, warnings and notes of a deck, rendered.
fn findings(requests: &str) -> String {
    let prepared = job::prepare_text("test.inp", &block(&steel(), requests), &Vec::new(), &Routines::none());
    prepared.diagnostics.render(&prepared.deck.sources)
}

#[test]
fn messages_list_available_variables() {
    let element = |words: &str| findings(&format!("*Output, field\n*Element Output\n {words}\n"));
    let message_text = element("PEQ");
    assert!(
        message_text.contains("M141")
            && message_text.contains("did you mean PEEQ?")
            && message_text.contains("MISES, PRESS"),
        "{message_text}"
    );
    // This stress component does not exist in an axisymmetric body, which the ledger reports.
    assert!(element("S13").is_empty(), "{}", element("S13"));
    assert!(element("MISES2").contains("MISES has no components"));
    let of = |card: &str, words: &str| findings(&format!("*Output, history\n{card}\n {words}\n"));
    assert!(of("*Node Output, nset=TIP", "QQQQQQQ").contains("available variables: U, V, A, RF, COORD"));
    assert!(of("*Energy Output", "U7").contains("U has the components U1, U2"));
    assert!(findings("*Output, field, variable=SOME\n").contains("M103"));
    assert!(findings("*Output, field\n*Element Output, position=MIDDLE\n S\n").contains("M103"));
    assert!(of("*Element Output, elset=ONE, position=NODES", "S").contains("always written at integration points"));
    assert!(
        findings("*Output, field\n*Element Output, position=NODES\n S\n")
            .contains("averages over the adjacent elements")
    );
}

#[test]
fn requests_without_effect_are_listed_with_a_reason() {
    let unused = |requests: &str| {
        let plan = prepared(&block(&steel(), requests), &[], &Routines::none()).plan;
        plan.ledger.unused.iter().map(|u| format!("{}: {}", u.what, u.why)).collect::<Vec<_>>().join("\n")
    };
    for known in NOT_SIMULATED {
        let message_text = unused(&format!("*Output, field\n*Element Output\n {}\n", known.name));
        assert!(
            message_text.contains(&format!("{}: {} ({}) is not simulated", known.name, known.name, known.words)),
            "{message_text}"
        );
    }
    let history = |card: &str, word: &str| unused(&format!("*Output, history\n{card}\n {word}\n"));
    assert!(history("*Node Output, nset=TIP", "S").contains("S is an element variable"));
    assert!(history("*Element Output, elset=ONE", "U").contains("U is a nodal variable"));
    assert!(history("*Energy Output, elset=ONE", "ALLIE").contains("sets have PARTKE"));
    assert!(history("*Element Output, elset=ONE", "PRESSURE").contains("has no history"));
    assert!(unused("*Output, field\n*Element Output\n S11\n").contains("frames show S with all components"));
    assert!(unused("*Output, field\n*Element Output\n ALLKE\n").contains("*OUTPUT, HISTORY"));
    assert!(unused("*Output, field\n*Element Output\n SDV1\n").contains("no value in this model"));
}

#[test]
fn explain_and_the_page_match_the_table() {
    let path = crate::common::project("docs/variables.md");
    let manual = variable_manual();
    if std::env::var_os("REVOLVE_BLESS").is_some() {
        std::fs::write(&path, &manual).expect("the page written");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == manual, "docs/variables.md is out of date: run again with REVOLVE_BLESS=1");
    assert_eq!(explain("variables"), Some(manual.clone()));
    for &variable in Variable::ALL {
        let row = variable.row();
        assert!(manual.contains(&format!("| `{}`", row.name)) && manual.contains(row.words), "{}", row.name);
        for name in labels(variable).iter().map(String::as_str).chain([row.name]) {
            let text = explain(&name.to_lowercase()).expect(name);
            assert!(text.contains(row.words) && row.labels.iter().all(|l| text.contains(l)), "{name}: {text}");
        }
    }
    for known in NOT_SIMULATED {
        assert!(explain(known.name).is_some_and(|t| t.contains(known.words) && t.contains("not simulated")));
    }
    // A word that is both a keyword and a variable is explained as both; the name of a variable is no abbreviation of a
    // keyword.
    let density = explain("density").expect("both");
    assert!(density.contains("*DENSITY") && density.contains("Mass per unit of current volume"));
    assert!(explain("ER").is_some_and(|t| !t.contains('*') || t.starts_with("ER:")));
    let names: BTreeSet<&str> = Variable::ALL.iter().map(|v| v.name()).collect();
    assert_eq!(names.len(), Variable::ALL.len());
}
