//! `*OUTPUT` with the cards that follow it, `*RESTART`, `*TIME POINTS`.

use super::contact;
use super::context::{Context, MAX_GENERATED};
use super::families::{OutputReader, StepReader};
use super::names::{SetKind, upper};
use super::sets::{sets_mut, sets_of};
use super::types::{
    ContactPairFilter, ElementSetId, MemberSet, NodeSetId, OutputCard, OutputInterval, OutputKind, OutputPosition,
    OutputRegion, OutputRequest, RestartRequest, TimePoints, TimePointsId,
};
use crate::deck::{Card, Diagnostic, Word};
use crate::variables::request::{self, SectionPoint, VariableRequest};
use crate::variables::statistic::Statistic;

/// Indices of the values of `OP` in the keyword table.
const NEW: usize = 0;
const ADD: usize = 1;

pub fn read_output(context: &mut Context<'_>, steps: &mut StepReader, output: &mut OutputReader, card: &Card) {
    let kind = if card.has("HISTORY") { OutputKind::History } else { OutputKind::Field };
    if !card.has("HISTORY") && !card.has("FIELD") {
        if card.has("DIAGNOSTICS") {
            return;
        }
        let diagnostic = Diagnostic::error("M101", "*OUTPUT requires FIELD or HISTORY")
            .at(card.span, "neither is given")
            .help("give FIELD or HISTORY; delete the card if it is one of CalculiX, which has no effect here");
        return context.diagnostics.push(diagnostic);
    }
    let Some(interval) = interval(context, card) else { return };
    output_operation(steps, card, kind, interval);
    note_time_marks(context, card);
    let variables = default_variables(card);
    let Some(sensor) = sensor(context, card) else { return };
    let request = OutputRequest {
        kind,
        interval,
        card: OutputCard::Output,
        variables,
        position: OutputPosition::Element,
        region: OutputRegion::Whole,
        statistics: Vec::new(),
        sensor,
        span: card.span,
    };
    output.close(context);
    if request.variables.is_empty() {
        output.empty = Some(card.span);
    } else {
        steps.state().outputs.push(request.clone());
    }
    output.request = Some(request);
}

/// Applies `OP` to the requests of earlier steps: NEW, the default, removes all field and history requests; REPLACE
/// removes those of the same type and interval; ADD removes none (ABAQUS Keywords Reference Guide, *OUTPUT).
fn output_operation(steps: &mut StepReader, card: &Card, kind: OutputKind, interval: OutputInterval) {
    match card.read::<usize>("OP") {
        NEW => {
            steps.clear_once("OUTPUT");
            steps.state().earlier_outputs.clear();
        }
        ADD => {}
        _ => steps.state().earlier_outputs.retain(|o| (o.kind, o.interval) != (kind, interval)),
    }
}

/// Reads `*RESTART, WRITE`, which remains in force until replaced. The default is one restart file per step;
/// FREQUENCY=0 ends restart output. READ is reported by the keyword table, because restarts are started from the
/// command line.
pub fn read_restart(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    if card.has("READ") {
        return;
    }
    if !card.has("WRITE") {
        return context.error("M101", "*RESTART requires WRITE", card.span, "WRITE is missing");
    }
    if card.value("FREQUENCY").is_some_and(|w| w.is("0")) {
        steps.state().restart = None;
        return;
    }
    let Some(interval) = interval(context, card) else { return };
    note_time_marks(context, card);
    let interval = if interval == OutputInterval::Default { OutputInterval::Number(1) } else { interval };
    steps.state().restart = Some(RestartRequest { interval, span: card.span });
}

fn note_time_marks(context: &mut Context<'_>, card: &Card) {
    if card.has("TIME MARKS") {
        let message = "with TIME MARKS=YES output is written at the first increment at or after the requested time";
        let note = Diagnostic::note("M142", message).at(card.span, "output does not change the increments");
        context.diagnostics.push(note);
    }
}

/// Returns the sensor name of a request; `None` if it is missing, which is reported.
fn sensor(context: &mut Context<'_>, card: &Card) -> Option<Option<String>> {
    if !card.has("SENSOR") {
        return Some(None);
    }
    let name = context.required(card, "NAME")?;
    if !card.has("HISTORY") {
        return context.refuse_value(card.span, "SENSOR requires *OUTPUT, HISTORY, SENSOR, NAME=");
    }
    Some(Some(upper(&name.text)))
}

/// Reads step times, listed or generated (ABAQUS Keywords Reference Guide, *TIME POINTS).
pub fn read_time_points(context: &mut Context<'_>, card: &Card) {
    let Some(name) = context.required(card, "NAME") else { return };
    let mut times: Vec<f64> = Vec::new();
    if card.has("GENERATE") {
        for (line, [first, last, step]) in card.lines.iter().zip(card.read_lines::<Vec<[f64; 3]>>()) {
            let count = ((last - first) / step * (1.0 + 1e-12)).floor();
            if !(0.0..=MAX_GENERATED as f64).contains(&count) {
                let message = "GENERATE requires first and last times in ascending order and at most 20 million points";
                return context.out_of_range(line.span, message);
            }
            times.extend((0..=count as usize).map(|i| first + i as f64 * step));
        }
    } else {
        times = card.read_lines();
    }
    if !times.windows(2).all(|w| w[0] < w[1]) {
        return context.out_of_range(card.span, "time points must be in ascending order");
    }
    context.model.output.time_points.push(TimePoints { name: upper(&name.text), times });
}

fn interval(context: &mut Context<'_>, card: &Card) -> Option<OutputInterval> {
    if let Some(word) = card.value("TIME POINTS") {
        let names: Vec<String> = context.model.output.time_points.iter().map(|p| p.name.clone()).collect();
        let index = names.iter().position(|n| *n == upper(&word.text));
        if index.is_none() {
            context.unknown("M117", "time points", word, |_| names.clone());
        }
        return index.map(|index| OutputInterval::Points(TimePointsId::new(index)));
    }
    let count = |name| card.read::<Option<usize>>(name).map(|count| u32::try_from(count).unwrap_or(u32::MAX));
    Some(match (card.read("TIME INTERVAL"), count("NUMBER INTERVAL"), count("FREQUENCY")) {
        (.., Some(0)) => OutputInterval::Never,
        (Some(time), ..) => OutputInterval::Time(time),
        (_, Some(number), _) => OutputInterval::Number(number),
        (.., Some(increments)) => OutputInterval::Increments(increments),
        _ => OutputInterval::Default,
    })
}

pub fn read_output_variables(
    context: &mut Context<'_>,
    steps: &mut StepReader,
    output: &mut OutputReader,
    card: &Card,
) {
    let Some(request) = output.request.clone() else {
        return context.misplaced(card, format!("*{} must follow an *OUTPUT", card.keyword.name), "OUTPUT");
    };
    output.empty = None;
    let Some(region) = output_region(context, output, card) else { return };
    let output_card = match card.keyword.name {
        "NODE OUTPUT" => OutputCard::Node,
        "ELEMENT OUTPUT" => OutputCard::Element,
        "ENERGY OUTPUT" => OutputCard::Energy,
        "INTEGRATED OUTPUT" => OutputCard::Integrated,
        "CONTACT OUTPUT" => OutputCard::Contact,
        _ => OutputCard::Incrementation,
    };
    if request.kind == OutputKind::Field && region != OutputRegion::Whole {
        context.inert(card, "field output is always written for the whole model");
    }
    let position = position(context, card, request.kind);
    let statistics = statistics(context, card, request.kind, &region);
    let mut variables = default_variables(card);
    let sides = section_points(context, card, &region);
    let named = if sides.is_some() { &card.lines[1..] } else { &card.lines[..] };
    let words = named.iter().flat_map(|l| &l.fields).filter(|w| !w.text.is_empty());
    let mut unknown = Vec::new();
    for word in words {
        match VariableRequest::parse(&upper(&word.text)) {
            Some(parsed) => match &sides {
                Some(sides) => variables.extend(sides.iter().filter_map(|side| parsed.at(*side))),
                None => variables.push(parsed),
            },
            None if out_of_plane(context, word) => {}
            None => unknown.push(word),
        }
    }
    unknown_variables(context, &unknown, output_card);
    if !variables.is_empty() {
        let request =
            OutputRequest { card: output_card, variables, position, region, statistics, span: card.span, ..request };
        steps.state().outputs.push(request);
    }
}

/// Returns the section points of shells listed on the first data line, counted from 1 on the side SNEG (ABAQUS
/// Keywords Reference Guide, *ELEMENT OUTPUT); `None` without such a line.
fn section_points(context: &mut Context<'_>, card: &Card, region: &OutputRegion) -> Option<Vec<SectionPoint>> {
    let line = card.lines.first().filter(|_| card.keyword.name == "ELEMENT OUTPUT")?;
    let words: Vec<&Word> = line.fields.iter().filter(|w| !w.text.is_empty()).collect();
    let numbers: Vec<usize> = words.iter().map(|w| w.text.trim().parse().ok()).collect::<Option<_>>()?;
    let members = match region {
        OutputRegion::Elements(set) => Some(&context.model.element_sets[*set].members),
        _ => None,
    };
    let meant = |e: &usize| members.is_none_or(|m| m.binary_search(e).is_ok());
    let shells = context.model.shell_sections.iter().filter(|s| s.elements.iter().any(meant));
    let mut counts: Vec<usize> = shells.map(|s| s.layers.iter().map(|layer| layer.points).sum()).collect();
    counts.dedup();
    let [count] = counts[..] else {
        let message = match counts.len() {
            0 => "section points require shell elements, and this request has none",
            _ => "these shells have different numbers of section points; use one request per section",
        };
        context.out_of_range(line.span, message);
        return Some(Vec::new());
    };
    let mut points = Vec::new();
    for (word, number) in words.iter().zip(numbers) {
        match number {
            1 => points.push(SectionPoint::Bottom),
            n if n == count => points.push(SectionPoint::Top),
            n if n == count / 2 + 1 => points.push(SectionPoint::Middle),
            n => {
                let message = format!("output at section point {n} of {count} is not supported");
                let help = format!("supported: 1 (side SNEG), {} (middle) and {count} (side SPOS)", count / 2 + 1);
                context.unsupported(word.span, message, &help);
            }
        }
    }
    Some(points)
}

/// Returns the position of field output. History output of elements is always at integration points (ABAQUS
/// Keywords Reference Guide, *ELEMENT OUTPUT, "Writing element output to the output database").
fn position(context: &mut Context<'_>, card: &Card, kind: OutputKind) -> OutputPosition {
    let Some(word) = card.value("POSITION").filter(|_| card.keyword.name == "ELEMENT OUTPUT") else {
        return OutputPosition::Element;
    };
    if card.read::<usize>("POSITION") < 2 {
        return OutputPosition::Element;
    }
    if kind == OutputKind::History {
        let message = "history output of elements is always written at integration points";
        context.diagnostics.push(Diagnostic::warning("M153", message).at(word.span, "not available at nodes"));
        return OutputPosition::Element;
    }
    let message = "elements have one integration point; nodal values are averages over the adjacent elements";
    context.diagnostics.push(Diagnostic::note("M153", message).at(word.span, "nodal values"));
    OutputPosition::Nodes
}

/// Returns the statistics of a history request over a set (`STATISTICS`, extension).
fn statistics(context: &mut Context<'_>, card: &Card, kind: OutputKind, region: &OutputRegion) -> Vec<Statistic> {
    let Some(word) = card.value("STATISTICS") else { return Vec::new() };
    if kind == OutputKind::Field || *region == OutputRegion::Whole {
        let message = "STATISTICS requires *OUTPUT, HISTORY and a set (NSET or ELSET)";
        context.out_of_range(word.span, message);
        return Vec::new();
    }
    let words: Vec<&str> = word.text.split([',', ' ']).filter(|w| !w.is_empty()).collect();
    let parsed: Option<Vec<Statistic>> = words.iter().map(|w| Statistic::parse(w)).collect();
    let Some(mut parsed) = parsed.filter(|parsed| !parsed.is_empty()) else {
        context.out_of_range(word.span, "STATISTICS must be MIN, MAX, MEAN or SUM, or several, as in \"MIN, MAX\"");
        return Vec::new();
    };
    parsed.sort_by_key(|statistic| *statistic as usize);
    parsed.dedup();
    parsed
}

/// Returns the request of `VARIABLE=PRESELECT` or `VARIABLE=ALL`.
fn default_variables(card: &Card) -> Vec<VariableRequest> {
    let choice = card.read::<Option<usize>>("VARIABLE");
    choice.map(|index| [VariableRequest::Preselect, VariableRequest::All][index]).into_iter().collect()
}

/// Names a surface for integrated output (ABAQUS Keywords Reference Guide, *INTEGRATED OUTPUT SECTION).
pub fn read_integrated_section(context: &mut Context<'_>, output: &mut OutputReader, card: &Card) {
    let Some(name) = context.required(card, "NAME") else { return };
    let Some(surface) = context.required(card, "SURFACE") else { return };
    if let Some(id) = context.surface_id(surface) {
        output.integrated_sections.insert(upper(&name.text), id);
    }
}

fn output_region(context: &mut Context<'_>, output: &mut OutputReader, card: &Card) -> Option<OutputRegion> {
    if card.keyword.name == "INTEGRATED OUTPUT" {
        return integrated_region(context, output, card);
    }
    if let Some(word) = card.value("NSET") {
        note_unused_filters(context, card);
        let index = output_set(context, SetKind::Nodes, word)?;
        return Some(OutputRegion::Nodes(NodeSetId::new(index)));
    }
    if let Some(word) = card.value("ELSET") {
        let index = output_set(context, SetKind::Elements, word)?;
        return Some(OutputRegion::Elements(ElementSetId::new(index)));
    }
    if card.keyword.name == "CONTACT OUTPUT" {
        return pairs_of(context, card);
    }
    Some(OutputRegion::Whole)
}

/// Returns the index of the set that a word names. A single node or element becomes a set of one.
fn output_set(context: &mut Context<'_>, kind: SetKind, word: &Word) -> Option<usize> {
    let members = context.members(kind, word)?;
    let [inner, outer] = context.names_of(word);
    let sets = sets_of(&context.model, kind);
    let known = sets.get_index_of(&inner).or_else(|| sets.get_index_of(&outer));
    if kind == SetKind::Elements {
        let key = if sets.contains_key(&inner) { &inner } else { &outer };
        context.edit_output_elements(word, key);
    }
    let set = MemberSet { members, span: word.span };
    Some(known.unwrap_or_else(|| sets_mut(&mut context.model, kind).insert_full(outer, set).0))
}

/// Lists the filters of pairs of a `*CONTACT OUTPUT` card with NSET as unused.
fn note_unused_filters(context: &mut Context<'_>, card: &Card) {
    const FILTERS: [&str; 7] =
        ["CPSET", "CONTACT PAIR", "GENERAL CONTACT", "SURFACE", "SECOND SURFACE", "MASTER", "SLAVE"];
    for parameter in FILTERS.iter().filter_map(|name| card.parameter(name)) {
        let why = "with NSET the contact variables of the nodes include all pairs";
        context.ignore(format!("CONTACT OUTPUT, {}", parameter.name), parameter.span, why);
    }
}

/// Returns the contact pairs selected by a `*CONTACT OUTPUT` card.
fn pairs_of(context: &mut Context<'_>, card: &Card) -> Option<OutputRegion> {
    let mut surfaces = Vec::new();
    for name in ["SURFACE", "SECOND SURFACE", "MASTER", "SLAVE"] {
        if let Some(word) = card.value(name) {
            surfaces.push(match contact::analytical_id(context, word) {
                Some(id) => context.model.surfaces.analytical_name(id).to_owned(),
                None => {
                    let id = context.surface_id(word)?;
                    context.model.surfaces.name(id).to_owned()
                }
            });
        }
    }
    let name = |parameter: &str| card.value(parameter).map(|w| upper(&w.text));
    let cpset = name("CPSET");
    let interaction = context.optional(card.value("CONTACT PAIR"), contact::interaction)?;
    let pairs = ContactPairFilter { cpset, interaction, general: card.has("GENERAL CONTACT"), surfaces };
    Some(if pairs == ContactPairFilter::default() { OutputRegion::Whole } else { OutputRegion::Pairs(pairs) })
}

fn integrated_region(context: &mut Context<'_>, output: &mut OutputReader, card: &Card) -> Option<OutputRegion> {
    if let Some(word) = card.value("SECTION") {
        let name = upper(&word.text);
        let Some(id) = output.integrated_sections.get(&name).copied() else {
            let mut names: Vec<String> = output.integrated_sections.keys().cloned().collect();
            names.sort();
            context.unknown("M114", "integrated output section", word, |_| names.clone());
            return None;
        };
        return Some(OutputRegion::Surface(id, name));
    }
    let word = context.required(card, "SURFACE")?;
    let id = context.surface_id(word)?;
    Some(OutputRegion::Surface(id, context.model.surfaces.name(id).to_owned()))
}

/// Returns whether a word is an out-of-plane component, which is zero in a body of revolution; the ledger lists it.
fn out_of_plane(context: &mut Context<'_>, word: &Word) -> bool {
    let name = upper(&word.text);
    let stem =
        |ends: &[&str]| ends.iter().find_map(|e| name.strip_suffix(e)).and_then(VariableRequest::parse).is_some();
    let zero = stem(&["13", "23"]) || matches!(name.as_str(), "U3" | "V3" | "A3" | "RF3" | "CF3" | "COOR3");
    if zero {
        let why = "this component is zero in a body of revolution";
        context.ignore(format!("{name} of an output request"), word.span, why);
    }
    zero
}

/// Reports all unknown variables of a card in one warning.
fn unknown_variables(context: &mut Context<'_>, words: &[&Word], card: OutputCard) {
    let Some(first) = words.first() else { return };
    let names: Vec<&str> = words.iter().map(|w| w.text.as_str()).collect();
    let message = match &names[..] {
        [name] => format!("unknown output variable {name}"),
        _ => format!("unknown output variables {}", names.join(", ")),
    };
    let mut diagnostic = Diagnostic::warning("M141", message).help(request::help(&upper(&first.text), card.places()));
    for word in words {
        let like = request::nearest_name(&upper(&word.text))
            .map_or("ignored".into(), |n| format!("ignored; did you mean {n}?"));
        diagnostic = diagnostic.at(word.span, like);
    }
    context.diagnostics.push(diagnostic);
}
