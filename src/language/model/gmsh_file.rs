//! Reader of Gmsh mesh files (`.msh`), versions 2.2 and 4.1 as text (Gmsh reference manual, "MSH file format").
//! Physical groups become the groups of [`super::mesh_data`].

use std::collections::{BTreeMap, HashMap};
use std::str::SplitAsciiWhitespace;

use super::mesh_data::{LabelledMesh, PlaneMesh};

/// Numbers of nodes and dimensions of the Gmsh element types 1 to 21.
const NODE_COUNTS: [usize; 21] = [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10];
const DIMENSIONS: [usize; 21] = [1, 2, 2, 3, 3, 3, 3, 1, 2, 2, 3, 3, 3, 3, 0, 2, 3, 3, 3, 2, 2];

/// What to save in place of other versions.
const SAVE_AS: &str = "save it as version 4.1 or 2.2, as text (Mesh.MshFileVersion = 4.1, Mesh.Binary = 0)";

pub(super) fn parse(text: &str) -> Result<PlaneMesh, String> {
    let version = version(text)?;
    let sections = sections(text)?;
    let section = |name: &str| sections.get(name).map(|t| WordReader(t.split_ascii_whitespace()));
    let mut names: HashMap<(usize, i64), String> = HashMap::new();
    if let Some(text) = sections.get("PhysicalNames") {
        for line in text.lines().skip_while(|l| l.trim().is_empty()).skip(1) {
            let mut words = WordReader(line.split_ascii_whitespace());
            let (Ok(dimension), Ok(tag)) = (words.count(), words.whole()) else { continue };
            let name = line.split('"').nth(1).ok_or("a physical name is not in quotes")?;
            names.insert((dimension, tag), name.to_owned());
        }
    }
    let nodes = section("Nodes").ok_or("it has no $Nodes section")?;
    let elements = section("Elements").ok_or("it has no $Elements section")?;
    let mut mesh = LabelledMesh::default();
    if version.starts_with("2.") {
        nodes_of_2(nodes, &mut mesh)?;
        elements_of_2(elements, &names, &mut mesh)?;
    } else if version == "4.1" {
        nodes_of_4(nodes, &mut mesh)?;
        let mut groups = HashMap::new();
        section("Entities").map_or(Ok(()), |words| entities(words, false, &mut groups))?;
        section("PartitionedEntities").map_or(Ok(()), |words| entities(words, true, &mut groups))?;
        elements_of_4(elements, &groups, &names, &mut mesh)?;
    } else {
        return Err(format!("version {version} is not supported: {SAVE_AS}"));
    }
    mesh.in_plane()
}

/// Returns the version of a text file.
fn version(text: &str) -> Result<&str, String> {
    if text.trim_start().starts_with("$NOD") {
        return Err(format!("version 1.0 is not supported: {SAVE_AS}"));
    }
    let header = text.trim_start().strip_prefix("$MeshFormat");
    let header = header.ok_or("it does not begin with $MeshFormat, so it is not a Gmsh mesh")?;
    let mut words = WordReader(header.split_ascii_whitespace());
    let version = words.word()?;
    if words.number()? != 0.0 {
        return Err(format!("binary files are not supported: {SAVE_AS}"));
    }
    Ok(version)
}

/// Returns the text between `$Name` and `$EndName` of each section.
fn sections(text: &str) -> Result<BTreeMap<&str, &str>, String> {
    let mut sections = BTreeMap::new();
    let mut remaining = text;
    while let Some(at) = remaining.find('$') {
        let name = remaining[at + 1..].split(|c: char| c.is_ascii_whitespace()).next().unwrap_or("");
        if name.is_empty() {
            return Err("a section has no name after $".into());
        }
        let body = &remaining[at + 1 + name.len()..];
        let end = body.find(&format!("$End{name}")).ok_or(format!("the section ${name} is not closed"))?;
        sections.insert(name, &body[..end]);
        remaining = &body[end + 4 + name.len()..];
    }
    Ok(sections)
}

struct WordReader<'a>(SplitAsciiWhitespace<'a>);

impl<'a> WordReader<'a> {
    fn word(&mut self) -> Result<&'a str, String> {
        self.0.next().ok_or_else(|| "a section ends early".into())
    }

    fn number(&mut self) -> Result<f64, String> {
        let word = self.word()?;
        word.parse().map_err(|_| format!("`{word}` is not a number"))
    }

    fn whole(&mut self) -> Result<i64, String> {
        let word = self.word()?;
        word.parse().map_err(|_| format!("`{word}` is not a whole number"))
    }

    fn count(&mut self) -> Result<usize, String> {
        usize::try_from(self.whole()?).map_err(|_| "a count is negative".into())
    }

    fn skip(&mut self, count: usize) -> Result<(), String> {
        (0..count).try_for_each(|_| self.word().map(|_| ()))
    }

    fn point(&mut self) -> Result<[f64; 3], String> {
        Ok([self.number()?, self.number()?, self.number()?])
    }
}

fn nodes_of_2(mut words: WordReader<'_>, mesh: &mut LabelledMesh) -> Result<(), String> {
    for _ in 0..words.count()? {
        let label = words.whole()?;
        mesh.add_point(label, words.point()?);
    }
    Ok(())
}

fn name_of(names: &HashMap<(usize, i64), String>, dimension: usize, tag: i64) -> String {
    names.get(&(dimension, tag)).cloned().unwrap_or(format!("PHYSICAL_{tag}"))
}

fn kind(number: usize) -> Result<(usize, usize), String> {
    let shape = number.checked_sub(1).and_then(|i| Some((*NODE_COUNTS.get(i)?, *DIMENSIONS.get(i)?)));
    shape.ok_or(format!("Gmsh element type {number} is not supported"))
}

fn elements_of_2(
    mut words: WordReader<'_>,
    names: &HashMap<(usize, i64), String>,
    mesh: &mut LabelledMesh,
) -> Result<(), String> {
    for _ in 0..words.count()? {
        let label = words.whole()?;
        let (count, dimension) = kind(words.count()?)?;
        let tags = words.count()?;
        let group = if tags > 0 { words.whole()? } else { 0 };
        words.skip(tags.saturating_sub(1))?;
        let nodes = (0..count).map(|_| words.whole()).collect::<Result<_, _>>()?;
        let cell = mesh.add_cell(label, dimension, nodes);
        if group != 0 {
            mesh.listed.add_cells(&name_of(names, dimension, group.abs()), [cell]);
        }
    }
    Ok(())
}

fn nodes_of_4(mut words: WordReader<'_>, mesh: &mut LabelledMesh) -> Result<(), String> {
    let blocks = words.count()?;
    words.skip(3)?;
    for _ in 0..blocks {
        let dimension = words.count()?;
        words.skip(1)?;
        let extra = if words.count()? == 0 { 0 } else { dimension };
        let count = words.count()?;
        let labels = (0..count).map(|_| words.whole()).collect::<Result<Vec<_>, _>>()?;
        for label in labels {
            mesh.add_point(label, words.point()?);
            words.skip(extra)?;
        }
    }
    Ok(())
}

/// Reads the physical groups of each entity. The entities of a partitioned mesh also have their parent and partitions.
fn entities(
    mut words: WordReader<'_>,
    is_partitioned: bool,
    groups: &mut HashMap<(usize, i64), Vec<i64>>,
) -> Result<(), String> {
    if is_partitioned {
        words.skip(1)?;
        let ghosts = words.count()?;
        words.skip(2 * ghosts)?;
    }
    let counts = [words.count()?, words.count()?, words.count()?, words.count()?];
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = words.whole()?;
            if is_partitioned {
                words.skip(2)?;
                let partitions = words.count()?;
                words.skip(partitions)?;
            }
            words.skip(if dimension == 0 { 3 } else { 6 })?;
            let tags = (0..words.count()?).map(|_| words.whole()).collect::<Result<Vec<_>, _>>()?;
            groups.insert((dimension, tag), tags);
            if dimension > 0 {
                let bounding = words.count()?;
                words.skip(bounding)?;
            }
        }
    }
    Ok(())
}

fn elements_of_4(
    mut words: WordReader<'_>,
    groups: &HashMap<(usize, i64), Vec<i64>>,
    names: &HashMap<(usize, i64), String>,
    mesh: &mut LabelledMesh,
) -> Result<(), String> {
    let blocks = words.count()?;
    words.skip(3)?;
    for _ in 0..blocks {
        let entity = (words.count()?, words.whole()?);
        let (count, dimension) = kind(words.count()?)?;
        let tags = groups.get(&entity).map_or(&[][..], Vec::as_slice);
        let sets: Vec<String> = tags.iter().map(|tag| name_of(names, entity.0, tag.abs())).collect();
        for _ in 0..words.count()? {
            let label = words.whole()?;
            let nodes = (0..count).map(|_| words.whole()).collect::<Result<_, _>>()?;
            let cell = mesh.add_cell(label, dimension, nodes);
            sets.iter().for_each(|set| mesh.listed.add_cells(set, [cell]));
        }
    }
    Ok(())
}
