//! Selection of triangles with nodally averaged dilation.

use crate::element::averaging::DilationAveraging;
use crate::model::{MaterialDefinition, Model, SolidSection};
use crate::plan::Report;
use crate::plan::solids::user_material::calls_routines_at_points;

/// Poisson's ratio above which triangles of an elastic material lock: there the bulk modulus is ten times the shear
/// modulus.
const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

/// Returns the averaging of the triangles of a section, if AVERAGED PRESSURE=YES is given or, by default, if they
/// would lock.
pub fn dilation_averaging(
    model: &Model,
    section: &SolidSection,
    corners: &[[u32; 4]],
    report: &mut Report,
) -> Option<DilationAveraging> {
    let material = &model.materials[section.material];
    let requested = section.controls.averaged;
    if requested == Some(false) {
        return None;
    }
    let triangles = corners.iter().filter(|c| c[2] == c[3]).count();
    let why_not = if triangles == 0 {
        Some("the section has no CAX3 elements")
    } else if section.controls.by_area {
        Some("not supported with WEIGHTING=AREA")
    } else if material.eos.is_some()
        || material.foam.shape.is_some()
        || material.has_strength_law()
        || calls_routines_at_points(material)
    {
        Some("it applies only to linear elasticity and rubber")
    } else {
        None
    };
    match (why_not, requested) {
        (Some(why), Some(true)) => report.add_unused_card(section.span, "AVERAGED PRESSURE", why),
        (None, _) if requested.is_some() || locks(material) => {
            let detail = "dilation averaged over nodes, against volumetric locking".into();
            report.ledger_row(section.span, "averaged pressure", triangles, "triangles", detail);
            return DilationAveraging::new(corners);
        }
        _ => {}
    }
    None
}

fn locks(material: &MaterialDefinition) -> bool {
    let stiff = material.elastic.is_some_and(|[_, poisson]| poisson > NEARLY_INCOMPRESSIBLE);
    stiff || material.plastic.is_some() || material.hyperelastic.is_some()
}
