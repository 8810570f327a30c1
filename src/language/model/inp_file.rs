//! Reader of mesh files in ABAQUS format (`.inp`): `*NODE`, `*ELEMENT`, `*NSET`, `*ELSET`, `*SURFACE` of element faces,
//! parts and instances. Other cards are listed in a note. The `*MESH` card determines the element type.

use std::collections::HashMap;

use super::element_words::element_shape;
use super::mesh_data::{LabelledMesh, PlaneMesh};
use super::placement::InstancePlacement;
use crate::deck::number::parse_number;

pub(super) fn parse(text: &str) -> Result<PlaneMesh, String> {
    let has_instances = text.lines().any(|line| keyword_of(line.trim()).is_some_and(|keyword| keyword == "INSTANCE"));
    let mut reader = InpReader {
        largest_member_count: MEMBERS[0] + MEMBERS[1] * text.len(),
        remaining_copies: COPIES[0] + COPIES[1] * text.len(),
        has_instances,
        ..InpReader::default()
    };
    for (number, line) in text.lines().enumerate() {
        reader.line(number + 1, line.trim())?;
    }
    reader.close_section();
    reader.read_deferred_lines()?;
    reader.mesh.in_plane()
}

/// Largest number of set members in a file: a constant, plus a number per byte of the file. GENERATE and sets of sets
/// could otherwise define any number of members in a few bytes.
const MEMBERS: [usize; 2] = [100_000, 64];

/// Largest number of lines of parts that instances repeat: a constant, plus a number per byte of the file.
const COPIES: [usize; 2] = [1_000_000, 4];

/// Kind of the current data lines.
#[derive(Clone, Debug, Default, PartialEq)]
enum InpSection {
    #[default]
    Ignored,
    Nodes(Option<String>),
    /// Number of nodes and dimension of the elements, and their set.
    Elements(usize, usize, Option<String>),
    Set(SetCard),
    /// Name of a surface of element faces.
    Surface(String),
    /// Data lines of `*INSTANCE` so far: a translation and a rotation.
    Instance(Vec<Vec<f64>>),
}

/// Data line of a set or surface, which may refer to elements and nodes of later lines.
struct DeferredLine<'a> {
    number: usize,
    /// Instance in which the line is.
    scope: String,
    card: InpSection,
    line: &'a str,
}

#[derive(Clone, Debug, PartialEq)]
struct SetCard {
    name: String,
    is_node_set: bool,
    is_generated: bool,
    /// Name of the instance whose labels are listed.
    instance: Option<String>,
}

/// Labels and sets of an instance, or of the lines outside of instances.
#[derive(Debug, Default)]
struct LabelScope {
    /// Labels in the mesh by those of the file; empty outside of instances.
    nodes: HashMap<i64, i64>,
    elements: HashMap<i64, i64>,
    /// Members of sets: labels in the mesh.
    node_sets: HashMap<String, Vec<i64>>,
    element_sets: HashMap<String, Vec<i64>>,
}

#[derive(Default)]
struct InpReader<'a> {
    mesh: LabelledMesh,
    section: InpSection,
    /// Labels and indices of the nodes or elements of the section so far, if it names a set.
    section_members: Vec<(i64, usize)>,
    /// Values read so far of an element that continues on the next line.
    element_values: Vec<i64>,
    /// Lines of each part with their numbers, and the part whose lines are collected.
    parts: HashMap<String, Vec<(usize, &'a str)>>,
    open_part: Option<String>,
    /// Whether the file has instances; without them parts are read where they are.
    has_instances: bool,
    /// Labels and sets by instance; the name is empty outside of instances.
    scopes: HashMap<String, LabelScope>,
    scope: String,
    /// Part of the open instance, and its placement once it is known.
    instance_part: Option<String>,
    placement: Option<InstancePlacement>,
    deferred: Vec<DeferredLine<'a>>,
    /// Number of set members so far, and its limit.
    member_count: usize,
    largest_member_count: usize,
    /// Number of lines of parts that instances may still repeat.
    remaining_copies: usize,
}

/// A keyword line: keyword and parameters in capitals.
struct InpCard<'a> {
    keyword: String,
    parameters: Vec<(String, &'a str)>,
}

impl<'a> InpCard<'a> {
    fn new(line: &'a str) -> InpCard<'a> {
        let parameters = line.split(',').skip(1).map(str::trim);
        let parameters = parameters
            .map(|p| p.split_once('=').unwrap_or((p, "")))
            .map(|(name, value)| (name.trim().to_uppercase(), value.trim().trim_matches('"')));
        InpCard { keyword: keyword_of(line).unwrap_or_default(), parameters: parameters.collect() }
    }

    fn value(&self, name: &str) -> Option<&'a str> {
        self.parameters.iter().find(|p| p.0 == name).map(|p| p.1)
    }

    fn required(&self, name: &str) -> Result<String, String> {
        let value = self.value(name).filter(|value| !value.is_empty());
        value.map(str::to_uppercase).ok_or_else(|| format!("*{} has no {name}=", self.keyword))
    }

    fn optional(&self, name: &str) -> Option<String> {
        self.value(name).map(str::to_uppercase)
    }
}

/// Returns the placement that the data lines of `*INSTANCE` give: a translation and a rotation.
fn placement(lines: &[Vec<f64>]) -> Result<Option<InstancePlacement>, String> {
    let Some(translation) = lines.first() else { return Ok(None) };
    let component = |i: usize| translation.get(i).copied().unwrap_or(0.0);
    if component(2) != 0.0 {
        return Err("an instance is moved out of the r-z plane".into());
    }
    let rotation = lines.get(1).map(|values| <[f64; 7]>::try_from(values.as_slice()));
    let rotation = rotation.transpose().map_err(|_| "the rotation of an instance has 7 values")?;
    Ok(Some(InstancePlacement::new([component(0), component(1)], rotation)?))
}

/// Returns the keyword of a line in capitals; `None` for comments and data lines.
fn keyword_of(line: &str) -> Option<String> {
    let text = line.strip_prefix('*').filter(|text| !text.starts_with('*'))?;
    let words = text.split(',').next().unwrap_or("").split_whitespace();
    Some(words.collect::<Vec<_>>().join(" ").to_uppercase())
}

fn data_fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim).filter(|field| !field.is_empty())
}

/// Reads a label. Some programs write `15.0`.
fn whole_number(field: &str) -> Result<i64, String> {
    let digits = field.strip_suffix(".0").unwrap_or(field);
    digits.parse().map_err(|_| format!("`{field}` is not a whole number"))
}

fn real_number(field: &str) -> Result<f64, String> {
    parse_number(field).map_err(|_| format!("`{field}` is not a number"))
}

impl<'a> InpReader<'a> {
    /// Reads a line of the file; errors have its number.
    fn line(&mut self, number: usize, line: &'a str) -> Result<(), String> {
        let keyword = keyword_of(line);
        if keyword.as_deref() == Some("END PART") {
            self.open_part = None;
        }
        if let Some(lines) = self.open_part.as_ref().and_then(|part| self.parts.get_mut(part)) {
            lines.push((number, line));
            return Ok(());
        }
        let result = match keyword {
            None if line.is_empty() || line.starts_with("**") => Ok(()),
            None => {
                let mut section = std::mem::take(&mut self.section);
                let result = self.data_line(&mut section, number, line);
                self.section = section;
                result
            }
            Some(_) => {
                let card = InpCard::new(line);
                self.close_section();
                self.place_part(&card).and_then(|()| self.begin(&card))
            }
        };
        // Lines of parts have their own number.
        result.map_err(|why| if why.starts_with("line ") { why } else { format!("line {number}: {why}") })
    }

    fn begin(&mut self, card: &InpCard<'_>) -> Result<(), String> {
        self.element_values.clear();
        self.section = match card.keyword.as_str() {
            "NODE" => InpSection::Nodes(card.optional("NSET")),
            "ELEMENT" => {
                let name = card.required("TYPE")?;
                let (count, dimension) = element_shape(&name)?;
                InpSection::Elements(count, dimension, card.optional("ELSET"))
            }
            "NSET" | "ELSET" => InpSection::Set(SetCard {
                name: card.required(&card.keyword)?,
                is_node_set: card.keyword == "NSET",
                is_generated: card.value("GENERATE").is_some(),
                instance: card.optional("INSTANCE"),
            }),
            "SURFACE" if card.value("TYPE").is_none_or(|kind| kind.eq_ignore_ascii_case("ELEMENT")) => {
                InpSection::Surface(card.required("NAME")?)
            }
            "PART" if self.has_instances => {
                let name = card.required("NAME")?;
                self.parts.insert(name.clone(), Vec::new());
                self.open_part = Some(name);
                InpSection::Ignored
            }
            "INSTANCE" => {
                if !self.scope.is_empty() {
                    return Err(format!("*INSTANCE within the instance {}", self.scope));
                }
                self.scope = card.required("NAME")?;
                self.scopes.entry(self.scope.clone()).or_default();
                self.instance_part = card.optional("PART");
                InpSection::Instance(Vec::new())
            }
            "END INSTANCE" => {
                self.scope.clear();
                self.placement = None;
                InpSection::Ignored
            }
            "HEADING" | "UNITS" | "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" => InpSection::Ignored,
            other => {
                self.note_unread(other.to_owned());
                InpSection::Ignored
            }
        };
        Ok(())
    }

    /// Reads the lines of the part of an instance, whose data lines end at a card.
    fn place_part(&mut self, card: &InpCard<'_>) -> Result<(), String> {
        let InpSection::Instance(lines) = std::mem::take(&mut self.section) else { return Ok(()) };
        self.placement = placement(&lines)?;
        let Some(part) = self.instance_part.take() else { return Ok(()) };
        let Some(lines) = self.parts.get(&part).cloned() else {
            // An independent instance has its own mesh.
            let has_mesh = card.keyword == "NODE";
            let reason = || format!("*INSTANCE names the part {part}, which is not defined before it");
            return if has_mesh { Ok(()) } else { Err(reason()) };
        };
        self.remaining_copies = self.remaining_copies.checked_sub(lines.len()).ok_or_else(|| {
            format!("the instances repeat more lines of parts than the limit for a file of this size, at part {part}")
        })?;
        lines.into_iter().try_for_each(|(number, line)| self.line(number, line))?;
        self.close_section();
        Ok(())
    }

    /// Adds the nodes or elements of the section to the set that it names.
    fn close_section(&mut self) {
        let (InpSection::Nodes(Some(set)) | InpSection::Elements(_, _, Some(set))) = &self.section else { return };
        let (set, is_node_set) = (set.clone(), matches!(self.section, InpSection::Nodes(_)));
        let (labels, indices): (Vec<i64>, Vec<usize>) = self.section_members.drain(..).unzip();
        self.remember(&set, is_node_set, &labels);
        self.add_to_groups(&set, is_node_set, &indices);
    }

    fn data_line(&mut self, section: &mut InpSection, number: usize, line: &'a str) -> Result<(), String> {
        match section {
            InpSection::Ignored => Ok(()),
            InpSection::Nodes(set) => self.node(set.is_some(), line),
            InpSection::Elements(count, dimension, set) => self.element(*count, *dimension, set.is_some(), line),
            InpSection::Set(_) | InpSection::Surface(_) => {
                let (scope, card) = (self.scope.clone(), section.clone());
                self.deferred.push(DeferredLine { number, scope, card, line });
                Ok(())
            }
            InpSection::Instance(lines) => {
                lines.push(data_fields(line).map(real_number).collect::<Result<_, _>>()?);
                Ok(())
            }
        }
    }

    /// Reads the lines of sets and surfaces, after all nodes and elements.
    fn read_deferred_lines(&mut self) -> Result<(), String> {
        for DeferredLine { number, scope, card, line } in std::mem::take(&mut self.deferred) {
            self.scope = scope;
            let result = match card {
                InpSection::Set(card) => self.set_members(&card, line),
                InpSection::Surface(name) => self.surface_faces(&name, line),
                _ => Ok(()),
            };
            result.map_err(|why| format!("line {number}: {why}"))?;
        }
        Ok(())
    }

    fn node(&mut self, is_listed: bool, line: &str) -> Result<(), String> {
        let mut fields = line.split(',').map(str::trim);
        let label = whole_number(fields.next().unwrap_or(""))?;
        let mut point = [0.0; 3];
        for (value, field) in point.iter_mut().zip(fields).filter(|(_, field)| !field.is_empty()) {
            *value = real_number(field)?;
        }
        if let Some(placement) = &self.placement {
            let [r, z] = placement.apply([point[0], point[1]]);
            point = [r, z, point[2]];
        }
        let label = self.mesh_label(label, true);
        let index = self.mesh.add_point(label, point);
        if is_listed {
            self.section_members.push((label, index));
        }
        Ok(())
    }

    fn element(&mut self, count: usize, dimension: usize, is_listed: bool, line: &str) -> Result<(), String> {
        for field in data_fields(line) {
            self.element_values.push(whole_number(field)?);
        }
        if self.element_values.len() <= count {
            return Ok(());
        }
        let values = std::mem::take(&mut self.element_values);
        let nodes = values[1..=count].iter().map(|&node| self.known_label(&self.scope, node, true)).collect();
        let label = self.mesh_label(values[0], false);
        let cell = self.mesh.add_cell(label, dimension, nodes);
        if is_listed {
            self.section_members.push((label, cell));
        }
        Ok(())
    }

    /// Returns the label in the mesh for a new label of the current scope. In an instance, a label that is used elsewhere is
    /// replaced.
    fn mesh_label(&mut self, label: i64, is_node: bool) -> i64 {
        let Some(scope) = self.scopes.get_mut(&self.scope).filter(|_| !self.scope.is_empty()) else { return label };
        let labels = if is_node { &mut scope.nodes } else { &mut scope.elements };
        let is_used = if is_node { self.mesh.point(label) } else { self.mesh.cell(label) }.is_some();
        let new_label = || if is_used { self.mesh.largest_label().saturating_add(1) } else { label };
        *labels.entry(label).or_insert_with(new_label)
    }

    /// Returns the label in the mesh for a label of an instance.
    fn known_label(&self, instance: &str, label: i64, is_node: bool) -> i64 {
        let scope = self.scopes.get(instance).filter(|_| !instance.is_empty());
        let labels = scope.map(|scope| if is_node { &scope.nodes } else { &scope.elements });
        labels.and_then(|labels| labels.get(&label)).copied().unwrap_or(label)
    }

    /// Adds members to a set of the current scope, to which later sets may refer.
    fn remember(&mut self, set: &str, is_node_set: bool, members: &[i64]) {
        let mut names = vec![(self.scope.clone(), set.to_owned())];
        if !self.scope.is_empty() {
            names.push((String::new(), format!("{}.{set}", self.scope)));
        }
        for (scope, name) in names {
            let scope = self.scopes.entry(scope).or_default();
            let sets = if is_node_set { &mut scope.node_sets } else { &mut scope.element_sets };
            sets.entry(name).or_default().extend(members);
        }
    }

    /// Adds indices to a group of the mesh, and in an instance to the group `INSTANCE.NAME`.
    fn add_to_groups(&mut self, set: &str, is_node_set: bool, indices: &[usize]) {
        let qualified = (!self.scope.is_empty()).then(|| format!("{}.{set}", self.scope));
        for name in [Some(set.to_owned()), qualified].into_iter().flatten() {
            if is_node_set {
                self.mesh.listed.add_points(&name, indices.iter().copied());
            } else {
                self.mesh.listed.add_cells(&name, indices.iter().copied());
            }
        }
    }

    /// Returns the members that a word of a data line denotes in a scope: a set or a label.
    fn members(&self, instance: &str, word: &str, is_node_set: bool) -> Result<Vec<i64>, String> {
        let of_scope = |scope: &str| {
            let scope = self.scopes.get(scope)?;
            if is_node_set { &scope.node_sets } else { &scope.element_sets }.get(&word.to_uppercase())
        };
        match of_scope(instance).or_else(|| of_scope("")) {
            Some(members) => Ok(members.clone()),
            None => {
                let (instance, label) = match (whole_number(word), word.rsplit_once('.')) {
                    (Ok(label), _) => (instance.to_owned(), label),
                    (Err(_), Some((instance, label))) => (instance.to_uppercase(), whole_number(label)?),
                    (Err(_), None) => return Err(format!("`{word}` is neither a set nor a label")),
                };
                Ok(vec![self.known_label(&instance, label, is_node_set)])
            }
        }
    }

    fn set_members(&mut self, card: &SetCard, line: &str) -> Result<(), String> {
        let instance = card.instance.clone().unwrap_or_else(|| self.scope.clone());
        let mut members = Vec::new();
        if card.is_generated {
            let numbers = data_fields(line).map(whole_number).collect::<Result<Vec<_>, _>>()?;
            let (first, last) = (numbers.first().copied().unwrap_or(0), numbers.get(1).copied().unwrap_or(0));
            let step = numbers.get(2).copied().unwrap_or(1).max(1);
            // One member above the limit is enough for the check below.
            let labels = (first..=last).step_by(step as usize).take(self.largest_member_count + 1);
            members.extend(labels.map(|label| self.known_label(&instance, label, card.is_node_set)));
        } else {
            for field in data_fields(line) {
                members.extend(self.members(&instance, field, card.is_node_set)?);
                if members.len() > self.largest_member_count {
                    break;
                }
            }
        }
        self.member_count += members.len();
        if self.member_count > self.largest_member_count {
            let limit = self.largest_member_count;
            return Err(format!("the sets have more than {limit} members, the limit for a file of this size"));
        }
        self.remember(&card.name, card.is_node_set, &members);
        let index = |label: &i64| if card.is_node_set { self.mesh.point(*label) } else { self.mesh.cell(*label) };
        let known: Vec<usize> = members.iter().filter_map(index).collect();
        if known.len() < members.len() {
            *self.mesh.listed.undefined_members.entry(card.name.clone()).or_default() += members.len() - known.len();
        }
        if !known.is_empty() {
            self.add_to_groups(&card.name, card.is_node_set, &known);
        }
        Ok(())
    }

    fn surface_faces(&mut self, name: &str, line: &str) -> Result<(), String> {
        let mut fields = data_fields(line);
        let (word, side) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""));
        let number = side.strip_prefix(['S', 's']).and_then(|digits| digits.parse::<usize>().ok());
        let Some(face) = number.and_then(|number| number.checked_sub(1)) else {
            self.note_unread(format!("SURFACE, NAME={name}"));
            return Ok(());
        };
        let members = self.members(&self.scope, word, false)?;
        let faces: Vec<_> = members.iter().filter_map(|&label| Some((self.mesh.cell(label)?, face))).collect();
        self.mesh.listed.surfaces.entry(name.to_owned()).or_default().extend(faces);
        Ok(())
    }

    fn note_unread(&mut self, card: String) {
        if !self.mesh.listed.unread.contains(&card) {
            self.mesh.listed.unread.push(card);
        }
    }
}
