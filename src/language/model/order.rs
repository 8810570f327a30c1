//! Order in which cards are read: definitions of nodes, elements, sets and surfaces before the cards that refer to
//! them. Decks may list cards in any order, because ABAQUS reads all model data before it resolves names.

use crate::deck::names::fold;
use crate::deck::rows::words;
use crate::deck::{Card, Sources};

/// Returns the cards of a deck or part in reading order. Cards of one rank keep their order, as do blocks (parts,
/// instances, the assembly, steps).
pub(super) fn ordered<'a>(cards: &[&'a Card], sources: &Sources) -> Vec<&'a Card> {
    let mut ordered = Vec::with_capacity(cards.len());
    let mut region: Vec<Vec<&Card>> = Vec::new();
    let first_step = cards.iter().position(|c| c.keyword.name == "STEP").unwrap_or(cards.len());
    let (model, steps) = cards.split_at(first_step);
    let mut inside: Option<&str> = None;
    for card in model {
        let name = card.keyword.name;
        match (inside, name) {
            (Some(end), _) => {
                region.last_mut().expect("a block is open").push(card);
                if name == end {
                    inside = None;
                }
            }
            (None, "ASSEMBLY" | "END ASSEMBLY") => {
                flush(&mut region, &mut ordered, sources);
                ordered.push(*card);
            }
            (None, _) => {
                region.push(vec![card]);
                inside = match name {
                    "PART" => Some("END PART"),
                    "INSTANCE" => Some("END INSTANCE"),
                    _ => None,
                };
            }
        }
    }
    // Sets, surfaces and amplitudes defined in steps belong to the whole model.
    const DATA: &[&str] = &["NSET", "ELSET", "SURFACE", "AMPLITUDE", "TIME POINTS", "INTEGRATED OUTPUT SECTION"];
    let is_model = |c: &&&Card| DATA.contains(&c.keyword.name);
    let (data, steps): (Vec<&Card>, Vec<&Card>) = steps.iter().partition(is_model);
    region.extend(data.into_iter().map(|card| vec![card]));
    flush(&mut region, &mut ordered, sources);
    ordered.extend(steps);
    ordered
}

/// Appends the cards of a region, sorted by rank.
fn flush<'a>(region: &mut Vec<Vec<&'a Card>>, all: &mut Vec<&'a Card>, sources: &Sources) {
    let first = |kinds: &[&str]| region.iter().position(|u| kinds.contains(&u[0].keyword.name)).unwrap_or(0);
    let first_definitions =
        [first(&["NODE", "NGEN", "MESH", "INSTANCE"]), first(&["ELEMENT", "ELGEN", "MESH", "INSTANCE"])];
    let mut units: Vec<(u8, Vec<&Card>)> = Vec::new();
    for (at, unit) in region.drain(..).enumerate() {
        // A set of labels before any node or element refers to later ones.
        let early = match unit[0].keyword.name {
            "NSET" => at < first_definitions[0],
            "ELSET" => at < first_definitions[1],
            _ => false,
        };
        units.push((if early { 2 } else { rank(unit[0]) }, unit));
    }
    units.sort_by_key(|unit| unit.0);
    region.extend(units.into_iter().map(|unit| unit.1));
    let sets = |unit: &Vec<&Card>| matches!(unit[0].keyword.name, "NSET" | "ELSET");
    if region.iter().any(sets) {
        put_members_first(region, sources);
    }
    all.extend(region.drain(..).flatten());
}

/// Returns the rank: nodes, elements, node sets of elements, surfaces, all other cards.
fn rank(card: &Card) -> u8 {
    match card.keyword.name {
        "HEADING" | "UNITS" | "PART" | "INSTANCE" | "NODE" | "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "SYSTEM"
        | "MESH" => 0,
        "NSET" if !card.has("ELSET") => 0,
        "ELEMENT" | "ELGEN" | "ELCOPY" | "ELSET" => 1,
        "NSET" => 2,
        "SURFACE" | "RIGID SURFACE" | "AMPLITUDE" | "TIME POINTS" => 3,
        _ => 4,
    }
}

/// Moves sets behind the sets that they list.
fn put_members_first(region: &mut Vec<Vec<&Card>>, sources: &Sources) {
    let mut index = 0;
    let mut moves = 0;
    while index < region.len() {
        let later = last_member(region, index, sources).filter(|_| moves < region.len());
        match later {
            Some(to) => {
                let unit = region.remove(index);
                region.insert(to, unit);
                moves += 1;
            }
            None => index += 1,
        }
    }
}

/// Returns the position of the last later definition of a set that the set at `at` lists; `None` if there is none, or
/// if an earlier one exists.
fn last_member(region: &[Vec<&Card>], at: usize, sources: &Sources) -> Option<usize> {
    let card = region[at][0];
    let parameter = Some(card.keyword.name).filter(|name| matches!(*name, "NSET" | "ELSET"))?;
    // Most rows have labels only.
    let labels = |text: &str| words(text).all(|word| word.parse::<i64>().is_ok());
    let named = card.rows.iter().filter(|row| !row.text(sources).is_some_and(labels));
    let names = named.flat_map(|row| row.line(sources).into_owned().fields);
    let names = names.filter(|w| w.text.parse::<i64>().is_err());
    let members: Vec<String> = names.map(|w| fold(&w.text)).filter(|n| !n.is_empty()).collect();
    let set_name = fold(&card.value(parameter)?.text);
    if members.is_empty() || members.contains(&set_name) {
        return None;
    }
    let defines = |unit: &Vec<&Card>| {
        let defining =
            matches!(unit[0].keyword.name, "NODE" | "NGEN" | "NFILL" | "NSET" | "ELEMENT" | "ELGEN" | "ELSET");
        defining && unit[0].value(parameter).is_some_and(|w| members.contains(&fold(&w.text)))
    };
    let is_defined_before = region[..at].iter().any(defines);
    let last = region[at + 1..].iter().rposition(defines)?;
    (!is_defined_before).then_some(at + 1 + last)
}
