//! Shapes of ABAQUS element types by name: what mesh generators write for edges and faces of the r-z plane.

/// Types of one node.
const POINTS: [&str; 6] = ["MASS", "ROTARYI", "HEATCAP", "SPRING1", "DASHPOT1", "PD3D"];
/// Lines of which the number at the end is the order of interpolation, and beams, whose cubic forms have two nodes.
const LINES_BY_ORDER: [&str; 8] = ["SAX", "DSAX", "MAX", "MGAX", "SFMAX", "PIPE2", "PIPE3", "B2"];
const BEAMS: &str = "B3";
/// Lines of which the number at the end is the number of nodes.
const LINES_BY_NODES: [&str; 10] = ["T2D", "T3D", "R2D", "RAX", "RB2D", "RB3D", "CONN2D", "CONN3D", "DC1D", "AC1D"];
const LINES_OF_TWO_NODES: [&str; 6] = ["SPRINGA", "SPRING2", "DASHPOTA", "DASHPOT2", "GAPUNI", "FRAME"];
/// Three-dimensional solids.
const SOLIDS: [&str; 9] = ["C3D", "SC6", "SC8", "EC3D", "PC3D", "COH3D", "DC3D", "AC3D", "CIN3D"];

/// Returns the number of nodes and the dimension of an element type.
///
/// # Errors
/// The reason if it is three-dimensional or unknown.
pub(super) fn element_shape(name: &str) -> Result<(usize, usize), String> {
    let begins = |heads: &[&str]| heads.iter().find_map(|head| name.strip_prefix(head));
    if POINTS.contains(&name) {
        return Ok((1, 0));
    }
    if begins(&SOLIDS).is_some() {
        return Err(format!("element type {name} is three-dimensional; mesh the r-z half plane instead"));
    }
    if begins(&LINES_OF_TWO_NODES).is_some() {
        return Ok((2, 1));
    }
    if let Some(order) = begins(&LINES_BY_ORDER).or_else(|| name.strip_prefix(BEAMS)) {
        return Ok((if first_number(order) == Some(2) { 3 } else { 2 }, 1));
    }
    let nodes_of_line = begins(&LINES_BY_NODES).and_then(first_number);
    // STRI65 has six nodes, R3D4 and M3D4 four.
    let nodes_of_face = || match name {
        "STRI65" => Some(6),
        _ => first_number(["2D", "3D"].iter().find_map(|space| name.split_once(space)).map_or(name, |parts| parts.1)),
    };
    match (nodes_of_line, nodes_of_face()) {
        (Some(nodes @ (2 | 3)), _) => Ok((nodes, 1)),
        (None, Some(2)) => Ok((2, 1)),
        (None, Some(nodes @ 3..=9)) => Ok((nodes, 2)),
        _ => Err(format!("element type {name} is not an element of the r-z plane")),
    }
}

/// Returns the first number in a text, of one digit.
fn first_number(text: &str) -> Option<usize> {
    text.chars().find_map(|c| c.to_digit(10)).map(|digit| digit as usize)
}

#[cfg(test)]
mod tests {
    use super::element_shape;

    #[test]
    fn words_of_mesh_generators_have_the_shape_that_they_stand_for() {
        for (words, shape) in [
            (&["T3D2", "T2D2", "B31H", "B21", "B33", "RAX2", "SAX1", "PIPE21", "SFMAX1", "GAPUNI", "R2D2"][..], (2, 1)),
            (&["T3D3", "B32", "SAX2", "B22H"][..], (3, 1)),
            (&["CPS3", "R3D3", "STRI3", "S3R", "CAX3", "M3D3", "CPEG3", "DC2D3", "ACAX3"][..], (3, 2)),
            (&["CPS4", "CAX4P", "S4", "S4R5", "R3D4", "M3D4R", "CGAX4R", "COHAX4", "DCAX4", "SFM3D4"][..], (4, 2)),
            (&["CPS6", "STRI65", "CAX6M"][..], (6, 2)),
            (&["CAX8R", "S8R5"][..], (8, 2)),
            (&["MASS", "SPRING1"][..], (1, 0)),
        ] {
            for word in words {
                assert_eq!(element_shape(word), Ok(shape), "{word}");
            }
        }
        for word in ["C3D8R", "COH3D8", "SC8R"] {
            assert!(element_shape(word).is_err_and(|why| why.contains("three-dimensional")), "{word}");
        }
        assert!(element_shape("XYZ").is_err());
    }
}
