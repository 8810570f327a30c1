//! Output of a mesh as a deck file for `*INCLUDE`.

use std::fmt::Write as _;

use super::mesh::{DeckLabels, FreeSide, MeshPart, ProjectileMesh, SurfacePart};

impl ProjectileMesh {
    /// Returns the deck: `*NODE`, `*ELEMENT, TYPE=CAX4R`, sets, surfaces and `*SOLID SECTION`, after lines of
    /// `comments`.
    pub fn deck(&self, labels: &DeckLabels, comments: &[String]) -> String {
        let mut text = String::new();
        comments.iter().for_each(|line| text += &format!("** {line}\n"));
        let name = |word: &str| format!("{}{word}", labels.prefix);
        let _ = writeln!(text, "*Node, nset={}", name("PROJECTILE"));
        for (n, [r, z]) in self.sheet.points.iter().enumerate() {
            let _ = writeln!(text, " {}, {r:.12e}, {z:.12e}", n + labels.first);
        }
        let hollow = self.request.cavity.is_some();
        let case = name(if hollow { "CASE" } else { "BODY" });
        self.elements(&mut text, &case, MeshPart::Case, labels.first);
        if self.parts.contains(&MeshPart::Fill) {
            self.elements(&mut text, &name("FILL"), MeshPart::Fill, labels.first);
        }
        if hollow {
            let fill = if self.parts.contains(&MeshPart::Fill) { format!(", {}", name("FILL")) } else { String::new() };
            let _ = writeln!(text, "*Elset, elset={}\n {case}{fill}", name("BODY"));
        }
        if self.in_nose > 0 {
            let last = labels.first + self.in_nose - 1;
            let _ = writeln!(text, "*Elset, elset={}, generate\n {}, {last}, 1", name("NOSE"), labels.first);
        }
        self.sets(&mut text, labels);
        self.surfaces(&mut text, labels);
        let _ = writeln!(text, "*Solid Section, elset={case}, material={}", labels.material);
        if self.parts.contains(&MeshPart::Fill) {
            let _ = writeln!(text, "*Solid Section, elset={}, material={}", name("FILL"), labels.fill);
        }
        text
    }

    fn elements(&self, text: &mut String, set: &str, part: MeshPart, first: usize) {
        let _ = writeln!(text, "*Element, type=CAX4R, elset={set}");
        let of_part = self.sheet.elements.iter().zip(&self.parts).enumerate().filter(|(_, (_, b))| **b == part);
        for (n, (corners, _)) in of_part {
            let [a, b, c, d] = corners.map(|c| c + first);
            let _ = writeln!(text, " {}, {a}, {b}, {c}, {d}", n + first);
        }
    }

    fn sets(&self, text: &mut String, labels: &DeckLabels) {
        let on_axis = (0..self.sheet.points.len()).filter(|&n| self.sheet.points[n][0] == 0.0);
        let end = self.outline.rim()[1];
        let at_base = (0..self.sheet.points.len()).filter(|&n| self.sheet.points[n][1] == end);
        let sets: [(&str, Vec<usize>); 6] = [
            ("AXIS", on_axis.collect()),
            ("BASE", at_base.collect()),
            ("TIP", vec![self.corners[0]]),
            ("SHOULDER", vec![self.corners[1]]),
            ("BACK", vec![self.corners[2]]),
            ("RIM", vec![self.corners[3]]),
        ];
        for (set, nodes) in sets {
            let _ = writeln!(text, "*Nset, nset={}{set}", labels.prefix);
            for line in nodes.chunks(12) {
                let line: Vec<String> = line.iter().map(|n| (n + labels.first).to_string()).collect();
                let _ = writeln!(text, " {}", line.join(", "));
            }
        }
    }

    /// Writes the surfaces. `OUTER` is all that can contact a target: nose, shank and base.
    fn surfaces(&self, text: &mut String, labels: &DeckLabels) {
        let outer: &[SurfacePart] = &[SurfacePart::Nose, SurfacePart::Shank, SurfacePart::Base];
        let surfaces: [(&str, &[SurfacePart]); 6] = [
            ("OUTER", outer),
            ("NOSE", &[SurfacePart::Nose]),
            ("SHANK", &[SurfacePart::Shank]),
            ("BASE", &[SurfacePart::Base]),
            ("INNER", &[SurfacePart::Inner]),
            ("FILL", &[SurfacePart::Fill]),
        ];
        for (surface, walls) in surfaces {
            let sides: Vec<_> = self.walls.iter().filter(|side| walls.contains(&side.part)).collect();
            if sides.is_empty() {
                continue;
            }
            let _ = writeln!(text, "*Surface, name={}{surface}", labels.prefix);
            for FreeSide { element, side, .. } in sides {
                let _ = writeln!(text, " {}, S{side}", element + labels.first);
            }
        }
    }
}
