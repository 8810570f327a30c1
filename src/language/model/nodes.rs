//! Reads nodes: `*NODE`, and the generators `*NGEN` and `*NFILL`.

use super::budget::BudgetedItem;
use super::context::Context;
use super::families::MeshReader;
use super::name::EntityName;
use super::names::SetKind;
use super::refinement::curves::{on_arc, polar_point};
use super::{contact, sets};
use crate::deck::rows::label_and_coordinates;
use crate::deck::{Card, DataLine, Diagnostic, Diagnostics, Span, Word};

pub fn read_nodes(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let sources = &context.deck.sources;
    let mut made = Vec::with_capacity(if card.has("NSET") { card.rows.len() } else { 0 });
    let mut again = RedefinedNodes::default();
    let polar = card.value("SYSTEM").is_some_and(|w| w.is("C"));
    context.model.mesh.points.reserve(card.rows.len());
    context.model.mesh.node_names.reserve(card.rows.len());
    for row in &card.rows {
        let short_form = row.text(sources).and_then(label_and_coordinates);
        let Some((label, [r, z])) = short_form.or_else(|| node_line(context, &row.line(sources))) else { continue };
        if context.nodes.find(&context.scope, label).is_some() {
            again.note(label, row.span());
        }
        let coordinates = if polar { polar_point(r, z) } else { [r, z] };
        let node = add_node(context, mesh, label, mesh.global_coordinates(coordinates));
        if made.capacity() > 0 {
            made.push(node);
        }
    }
    again.report(&mut context.diagnostics);
    sets::collect(context, SetKind::Nodes, card, "NSET", made);
}

fn node_line(context: &mut Context<'_>, line: &DataLine) -> Option<(i64, [f64; 2])> {
    let label = context.integer(line, 0, "the node label")?;
    // Report errors of both fields.
    let coordinates = [1, 2].map(|at| context.number_or(line, at, 0.0));
    Some((label, [coordinates[0]?, coordinates[1]?]))
}

/// Adds a node in the current scope. If the label exists, the node is moved: the last definition is used.
pub fn add_node(context: &mut Context<'_>, mesh: &mut MeshReader, label: i64, [r, z]: [f64; 2]) -> usize {
    let position = mesh.placement.as_ref().map_or([r, z], |placement| placement.apply([r, z]));
    if let Some(known) = context.nodes.find(&context.scope, label) {
        let previous = std::mem::replace(&mut context.model.mesh.points[known], position);
        if previous != position {
            mesh.moved.insert(known, mesh.current_card);
        }
        return known;
    }
    let index = context.model.mesh.points.len();
    context.model.mesh.points.push(position);
    context.model.mesh.node_names.push(EntityName::of_label(&context.scope, label));
    context.nodes.insert(&context.scope, label, index);
    index
}

fn label_of(context: &mut Context<'_>, word: Option<&Word>, line: &DataLine, what: &str) -> Option<(i64, usize)> {
    let Some(word) = word else {
        let diagnostic = Diagnostic::error("M102", format!("{what} is missing")).at(line.span, "here");
        return context.diagnostics.refuse(diagnostic);
    };
    let label = word.integer(&mut context.diagnostics)?;
    match context.nodes.find(&context.scope, label) {
        Some(index) => Some((label, index)),
        None if context.missing.nodes || context.missing.everything => {
            context.missing.nodes = true;
            None
        }
        None => {
            let message = format!("{what} {label} is not defined");
            context.diagnostics.refuse(Diagnostic::error("M110", message).at(word.span, "no such node"))
        }
    }
}

/// Generates nodes between two nodes (ABAQUS Keywords Guide, *NGEN), on a line or, with LINE=C, on an arc.
pub fn read_ngen(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let arc = card.value("LINE").is_some_and(|w| w.is("C"));
    if let Some(line) = card.value("LINE").filter(|w| !w.is("C")) {
        context.unsupported(line.span, format!("LINE={} is not supported", line.text), "use a straight line or LINE=C");
    }
    let made = card.lines.iter().filter_map(|line| ngen_line(context, mesh, line, arc)).flatten().collect();
    sets::collect(context, SetKind::Nodes, card, "NSET", made);
}

fn ngen_line(context: &mut Context<'_>, mesh: &mut MeshReader, line: &DataLine, arc: bool) -> Option<Vec<usize>> {
    let normal = context.number_or(line, 9, 0.0)?;
    let (first, from) = label_of(context, line.field(0), line, "the first node")?;
    let (last, end) = label_of(context, line.field(1), line, "the last node")?;
    let step = line.field(2).map_or(Some(1), |w| w.integer(&mut context.diagnostics))?;
    let span = (i128::from(last) - i128::from(first)).abs();
    if step <= 0 || span % i128::from(step) != 0 {
        let message = format!("label {last} cannot be reached from {first} in increments of {step}");
        return context.refuse_value(line.span, message);
    }
    let count = count(context, span / i128::from(step), line.span)?;
    let (a, b) = (context.model.mesh.points[from], context.model.mesh.points[end]);
    let mut arc_centre = None;
    if arc {
        let rough_centre = centre(context, line)?;
        arc_centre = Some(contact::arc_centre(context, a, b, rough_centre, line.span)?);
    }
    let sign = (last - first).signum();
    let mut made = vec![from];
    for i in 1..count {
        let s = i as f64 / count as f64;
        let [r, z] = match arc_centre {
            Some(c) => on_arc(a, b, c, normal, s),
            None => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])],
        };
        made.push(place_generated(context, mesh, first + sign * step * i as i64, [r, z], line.span));
    }
    made.push(end);
    if let (Some(centre), true) = (arc_centre, context.deck.mesh_scaling.is_some()) {
        context.scaling.curves.record_arc(&made, centre, normal);
    }
    Some(made)
}

/// Adds a generated node without placement by the instance, because its end nodes are placed already.
pub fn place_generated(
    context: &mut Context<'_>,
    mesh: &mut MeshReader,
    label: i64,
    [r, z]: [f64; 2],
    span: Span,
) -> usize {
    let known = context.nodes.find(&context.scope, label).map(|n| (n, context.model.mesh.points[n]));
    let placement = mesh.placement.take();
    let index = add_node(context, mesh, label, [r, z]);
    mesh.placement = placement;
    if let Some((node, before)) = known {
        let far = (before[0] - r).abs().max((before[1] - z).abs());
        if far > 1e-6 * r.abs().max(z.abs()) {
            mesh.note_regenerated_node(node, label, span);
        }
    }
    index
}

fn centre(context: &mut Context<'_>, line: &DataLine) -> Option<[f64; 2]> {
    if line.field(3).is_some() {
        let is_zero = |word: &&Word| word.text.parse().is_ok_and(|value: f64| value == 0.0);
        if let Some(word) = [4, 5].into_iter().filter_map(|k| line.field(k)).find(|word| !is_zero(word)) {
            context.report_surplus(word, "the centre is given by a node or by its coordinates");
        }
        let (_, index) = label_of(context, line.field(3), line, "the centre node")?;
        return Some(context.model.mesh.points[index]);
    }
    Some([context.number(line, 4, "r of the centre")?, context.number(line, 5, "z of the centre")?])
}

fn count(context: &mut Context<'_>, count: i128, span: Span) -> Option<usize> {
    let count = count.max(1);
    context.fits_budget(BudgetedItem::Nodes, count.unsigned_abs(), span).then_some(count as usize)
}

/// Generates rows of nodes between corresponding nodes of two sets (ABAQUS Keywords Guide, *NFILL).
pub fn read_nfill(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let singular = card.read::<Option<usize>>("SINGULAR").unwrap_or(0);
    let spacing = FillSpacing { bias: card.read("BIAS"), two_step: card.has("TWO STEP"), singular };
    let made = card.lines.iter().filter_map(|line| nfill_line(context, mesh, line, &spacing)).flatten().collect();
    sets::collect(context, SetKind::Nodes, card, "NSET", made);
}

fn nfill_line(
    context: &mut Context<'_>,
    mesh: &mut MeshReader,
    line: &DataLine,
    spacing: &FillSpacing,
) -> Option<Vec<usize>> {
    let (Some(first), Some(second)) = (line.field(0), line.field(1)) else {
        let diagnostic = Diagnostic::error("M102", "two node sets are required").at(line.span, "here");
        return context.diagnostics.refuse(diagnostic);
    };
    let (starts, ends) = (nodes_in_order(context, mesh, first)?, nodes_in_order(context, mesh, second)?);
    let intervals = context.integer(line, 2, "the number of intervals")?;
    let step = line.field(3).map_or(Some(1), |w| w.integer(&mut context.diagnostics))?;
    if context.missing.nodes && starts.len() != ends.len() {
        return None;
    }
    if starts.len() != ends.len() || intervals < 1 || step < 1 {
        let message = format!("the sets must have equal numbers of nodes, found {} and {}", starts.len(), ends.len());
        return context.refuse_value(line.span, message);
    }
    count(context, i128::from(intervals) * starts.len() as i128, line.span)?;
    if (spacing.two_step || spacing.singular > 0) && intervals % 2 != 0 {
        return context.refuse_value(line.span, "TWO STEP and SINGULAR require an even number of intervals");
    }
    let shares = shares(intervals as usize, spacing);
    let (mut made, mut rows) = (Vec::new(), Vec::new());
    for (a, b) in starts.iter().zip(&ends) {
        let (start, end) = (context.model.mesh.points[*a], context.model.mesh.points[*b]);
        let label = label_of_index(context, *a)?;
        let row = made.len();
        for (i, s) in shares.iter().enumerate() {
            let position = [start[0] + s * (end[0] - start[0]), start[1] + s * (end[1] - start[1])];
            made.push(place_generated(context, mesh, label + step * (i as i64 + 1), position, line.span));
        }
        rows.push(made[row..].to_vec());
        made.extend([*a, *b]);
    }
    if context.deck.mesh_scaling.is_some() {
        context.scaling.curves.record_rows([&starts, &ends], &rows, &shares);
    }
    Some(made)
}

/// Returns the nodes of a set: in the given order for an UNSORTED set, otherwise in order of labels. The new nodes
/// of a refined mesh have no order and are left out.
pub fn nodes_in_order(context: &mut Context<'_>, mesh: &mut MeshReader, word: &Word) -> Option<Vec<usize>> {
    if let Some(nodes) = context.names_of(word).iter().find_map(|name| mesh.unsorted.get(name)).cloned() {
        context.edit_nodes(word, &nodes, true);
        return Some(nodes);
    }
    let mut nodes = context.original_nodes(word)?;
    nodes.sort_by_key(|&n| (label_of_index(context, n), n));
    Some(nodes)
}

pub fn label_of_index(context: &Context<'_>, index: usize) -> Option<i64> {
    context.model.mesh.node_names[index].rsplit('.').next()?.parse().ok()
}

/// Spacing of nodes generated by `*NFILL`.
struct FillSpacing {
    bias: f64,
    two_step: bool,
    /// Quarter-point spacing at the first (1) or second (2) line; 0 for none.
    singular: usize,
}

/// Returns the positions of the inner nodes in (0, 1). Each interval is `bias` times as long as the next one; with `TWO
/// STEP` this holds for pairs of equal intervals. With `SINGULAR` the node next to that line is at a quarter of the
/// first pair (ABAQUS Keywords Guide, *NFILL).
fn shares(intervals: usize, spacing: &FillSpacing) -> Vec<f64> {
    let power = |i: usize| if spacing.two_step { i / 2 } else { i };
    let lengths: Vec<f64> = (0..intervals).map(|i| spacing.bias.powi(-(power(i) as i32))).collect();
    let total: f64 = lengths.iter().sum();
    let mut sum = 0.0;
    let mut shares: Vec<f64> = lengths[..intervals - 1]
        .iter()
        .map(|l| {
            sum += l / total;
            sum
        })
        .collect();
    match spacing.singular {
        1 => shares[0] = 0.25 * shares.get(1).copied().unwrap_or(1.0),
        2 => {
            let last = intervals - 2;
            shares[last] = 1.0 - 0.25 * (1.0 - if last > 0 { shares[last - 1] } else { 0.0 });
        }
        _ => {}
    }
    shares
}

/// Nodes that a card defines again.
#[derive(Default)]
struct RedefinedNodes {
    first: Option<(i64, Span)>,
    count: usize,
}

impl RedefinedNodes {
    fn note(&mut self, label: i64, span: Span) {
        self.first.get_or_insert((label, span));
        self.count += 1;
    }

    fn report(self, diagnostics: &mut Diagnostics) {
        let Some((label, span)) = self.first else { return };
        let more = if self.count > 1 { format!(", and {} more nodes are", self.count - 1) } else { " is".into() };
        let diagnostic = Diagnostic::warning("M164", format!("node {label}{more} defined again"));
        diagnostics.push(diagnostic.at(span, "the last definition is used").help("define each node once"));
    }
}
