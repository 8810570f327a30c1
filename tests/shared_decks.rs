//! Decks of others: each gives a model, or located messages that name exactly what is not supported.

mod common;

use revolve::deck::{self, Severity};
use revolve::model;

/// Deck, and the codes of its errors (empty: it gives a model).
const EXPECTED: &[(&str, &[&str])] = &[
    ("Ferrite-FEM__FerriteMeshParser.jl/twoinstances.inp", &["M121"]),
    ("Ferrite-FEM__FerriteMeshParser.jl/unsupported_element.inp", &["M120", "M121"]),
    ("JuliaFEM__AbaqusReader.jl/contact_hertz.inp", &["D201", "M104", "M121"]),
    ("JuliaFEM__AbaqusReader.jl/hypermesh_model.inp", &["M104"]),
    ("USArmyResearchLab__PyVUMAT/example.inp", &["M121"]),
    ("YB-LIM__Powder_Metal_CREEP/Indentation.inp", &["D201", "M104", "M106", "M121"]),
    ("calculix__CalculiX-Examples/solve_acd.inp", &["D002", "D201", "M110"]),
    ("hzhangolemiss__VUMAT-DSGZs/CubicElement-Radial_VUMAT_D.inp", &["M121"]),
    ("mauroarcidiacono__Abaqus-VUMAT-Johnson-Cook/jc_ti64_abq_builtin.inp", &["M121"]),
    ("ngrilli__PyBristolFE/TwoPlainStrainTriangles.inp", &["D304", "M104", "M121"]),
    ("pantale__DynELA-v3.0/BarNecking.inp", &[]),
    ("pantale__DynELA-v3.0/Radial.inp", &[]),
    ("pantale__DynELA-v3.0/Taylor.inp", &[]),
    ("pantale__DynELA-v3.0/Torus.inp", &["M106", "M121"]),
    ("philipcardiff__abaqus-example-vumat/test.inp", &["M121"]),
    ("sfepy__sfepy/abaqus_quad_tri.inp", &["M121"]),
];

#[test]
fn each_gives_a_model_or_says_what_is_not_supported() {
    let root = common::project("../shared/decks");
    if !root.exists() {
        println!("left out: decks of others (there is no {})", root.display());
        return;
    }
    for (name, expected) in EXPECTED {
        let (deck, mut diagnostics) = deck::read(&root.join(name), &[]);
        let (model, found) = model::build(&deck);
        diagnostics.append(found);
        let errors: Vec<_> = diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
        let mut codes: Vec<_> = errors.iter().map(|d| d.code).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(&codes, expected, "{name}:\n{}", diagnostics.render(&deck.sources));
        assert!(errors.iter().all(|d| !d.labels.is_empty()), "{name}: every error has a place");
        if expected.is_empty() {
            assert!(!model.mesh.points.is_empty(), "{name}");
        }
    }
}

#[test]
fn the_taylor_deck_is_understood_whole() {
    let path = common::project("../shared/decks/pantale__DynELA-v3.0/Taylor.inp");
    if !path.exists() {
        println!("left out: the Taylor deck (there is no {})", path.display());
        return;
    }
    let (deck, _) = deck::read(&path, &[]);
    let (model, _) = model::build(&deck);
    assert_eq!((model.mesh.points.len(), model.mesh.elements.len()), (306, 250));
    assert_eq!(model.sections[0].elements.len(), 250);
    let steel = &model.materials[model.sections[0].material];
    assert_eq!(steel.density, Some(7.83e-9));
    assert_eq!(steel.elastic, Some([206_000.0, 0.3]));
    assert!(
        matches!(steel.plastic, Some(model::Plastic::JohnsonCook(p)) if p == [806.0, 614.0, 0.168, 1.1, 1540.0, 20.0])
    );
    assert!(matches!(steel.rate, Some(model::RateDependence::JohnsonCook([0.0089, 1.0]))));
    assert_eq!(model.steps[0].duration, 8e-5);
    assert_eq!(model.steps[0].bulk_viscosity, [0.06, 1.2]);
    assert_eq!(model.initial_conditions.len(), 3);
}
