//! Reader of mesh files in ABAQUS format (`.inp`): `*NODE`, `*ELEMENT`, `*NSET`, `*ELSET`. Other cards are listed in a
//! note. The `*MESH` card determines the element type.

use std::collections::HashMap;

use super::mesh_data::{MeshFile, MeshGroups};

pub(super) fn parse(text: &str) -> Result<MeshFile, String> {
    let mut reader = InpReader { most: MEMBERS[0] + MEMBERS[1] * text.len(), ..InpReader::default() };
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        let result = if line.starts_with("**") || line.is_empty() {
            Ok(())
        } else if let Some(card) = line.strip_prefix('*') {
            reader.begin(card)
        } else {
            let reading = std::mem::take(&mut reader.reading);
            let result = reader.data(&reading, line);
            reader.reading = reading;
            result
        };
        result.map_err(|why| format!("line {}: {why}", number + 1))?;
    }
    reader.mesh.finish(false)
}

/// Largest number of set members in a file: a constant, plus a number per byte of the file. GENERATE and sets of sets
/// could otherwise define any number of members in a few bytes.
const MEMBERS: [usize; 2] = [100_000, 64];

/// Kind of the current data lines.
#[derive(Clone, Debug, Default, PartialEq)]
enum InpSection {
    #[default]
    Nothing,
    Nodes(Option<String>),
    /// Number of nodes and dimension of the elements, and their set.
    Elements(usize, usize, Option<String>),
    /// Name, whether it is a node set, and whether the labels are generated.
    Set(String, bool, bool),
}

#[derive(Default)]
struct InpReader {
    mesh: MeshGroups,
    reading: InpSection,
    /// Values read so far of an element that continues on the next line.
    begun: Vec<i64>,
    nodes: HashMap<String, Vec<i64>>,
    elements: HashMap<String, Vec<i64>>,
    /// Number of set members so far, and its limit.
    members: usize,
    most: usize,
}

/// Returns the number of nodes and the dimension of an ABAQUS element type; `None` for unsupported types.
fn shape(name: &str) -> Option<(usize, usize)> {
    let digits: String =
        name.chars().rev().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
    let count: usize = digits.chars().rev().collect::<String>().parse().ok()?;
    let line = ["T2D", "T3D", "B2", "B3", "RAX", "R2D", "SAX", "MAX"].iter().any(|p| name.starts_with(p));
    match name {
        "MASS" | "ROTARYI" | "SPRING1" | "DASHPOT1" => Some((1, 0)),
        "B21" | "B31" | "SAX1" | "MAX1" => Some((2, 1)),
        "B22" | "B32" | "SAX2" | "MAX2" => Some((3, 1)),
        "T2D2" | "T3D2" | "RAX2" | "R2D2" => Some((2, 1)),
        "T2D3" | "T3D3" => Some((3, 1)),
        _ if line || name.starts_with("C3D") || name.starts_with("COH") => None,
        _ => Some((count, 2)),
    }
}

impl InpReader {
    fn begin(&mut self, card: &str) -> Result<(), String> {
        let mut parts = card.split(',').map(str::trim);
        let keyword: String =
            parts.next().unwrap_or("").split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase();
        let parameters: Vec<(String, &str)> = parts
            .map(|p| p.split_once('=').unwrap_or((p, "")))
            .map(|(name, value)| (name.trim().to_uppercase(), value.trim().trim_matches('"')))
            .collect();
        let value = |name: &str| parameters.iter().find(|p| p.0 == name).map(|p| p.1);
        let owned = |name: &str| value(name).map(str::to_owned);
        self.reading = match keyword.as_str() {
            "NODE" => InpSection::Nodes(owned("NSET")),
            "ELEMENT" => {
                let name = value("TYPE").ok_or("*ELEMENT has no TYPE=")?.to_uppercase();
                let (count, dimension) =
                    shape(&name).ok_or(format!("element type {name} is not an element of the r-z plane"))?;
                InpSection::Elements(count, dimension, owned("ELSET"))
            }
            "NSET" | "ELSET" => {
                let name = owned(&keyword).ok_or(format!("*{keyword} has no {keyword}="))?;
                InpSection::Set(name, keyword == "NSET", value("GENERATE").is_some())
            }
            "HEADING" | "UNITS" => InpSection::Nothing,
            _ => {
                if !self.mesh.unread.contains(&keyword) {
                    self.mesh.unread.push(keyword);
                }
                InpSection::Nothing
            }
        };
        Ok(())
    }

    fn data(&mut self, reading: &InpSection, line: &str) -> Result<(), String> {
        let fields = || line.split(',').map(str::trim).filter(|f| !f.is_empty());
        let whole = |f: &str| f.parse::<i64>().map_err(|_| format!("`{f}` is not a whole number"));
        match reading {
            InpSection::Nothing => {}
            InpSection::Nodes(set) => {
                let mut words = fields();
                let label = whole(words.next().unwrap_or(""))?;
                let mut point = [0.0; 3];
                for (value, field) in point.iter_mut().zip(words) {
                    *value =
                        crate::deck::number::parse_number(field).map_err(|_| format!("`{field}` is not a number"))?;
                }
                self.mesh.node(label, point);
                if let Some(set) = set {
                    self.nodes.entry(set.to_uppercase()).or_default().push(label);
                    self.mesh.add_nodes(set, &[label]);
                }
            }
            InpSection::Elements(count, dimension, set) => {
                for field in fields() {
                    self.begun.push(whole(field)?);
                }
                if self.begun.len() > *count {
                    let words = std::mem::take(&mut self.begun);
                    let sets = set.as_slice();
                    if let Some(set) = sets.first() {
                        self.elements.entry(set.to_uppercase()).or_default().push(words[0]);
                    }
                    self.mesh.cell(words[0], *dimension, words[1..=*count].to_vec(), sets);
                }
            }
            InpSection::Set(name, of_nodes, generated) => {
                let known = if *of_nodes { &self.nodes } else { &self.elements };
                let mut members = Vec::new();
                if *generated {
                    let numbers = fields().map(whole).collect::<Result<Vec<_>, _>>()?;
                    let (first, last) = (numbers.first().copied().unwrap_or(0), numbers.get(1).copied().unwrap_or(0));
                    let step = numbers.get(2).copied().unwrap_or(1).max(1);
                    // One member above the limit is enough for the check below.
                    members.extend((first..=last).step_by(step as usize).take(self.most + 1));
                } else {
                    for field in fields() {
                        match known.get(&field.to_uppercase()) {
                            Some(set) => members.extend(set),
                            None => members.push(whole(field)?),
                        }
                        if members.len() > self.most {
                            break;
                        }
                    }
                }
                self.members += members.len();
                if self.members > self.most {
                    return Err(format!(
                        "the sets have more than {} members, the limit for a file of this size",
                        self.most
                    ));
                }
                let known_sets = if *of_nodes { &mut self.nodes } else { &mut self.elements };
                known_sets.entry(name.to_uppercase()).or_default().extend(&members);
                if *of_nodes {
                    self.mesh.add_nodes(name, &members);
                } else {
                    self.mesh.add_cells(name, &members);
                }
            }
        }
        Ok(())
    }
}
