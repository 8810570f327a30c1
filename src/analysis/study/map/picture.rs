//! Picture of an error map over the undeformed mesh.

use super::ErrorMap;
use crate::model::Mesh;
use crate::output::drawing::{Colour, Drawing, LineStroke, ShapePaint, TextAnchor, TextLabel};
use crate::study::table::{digits, short};

/// Size of the plot and margins in points; the lower one contains the colour bar.
const PLOT: [f64; 2] = [860.0, 560.0];
const MARGIN: [f64; 4] = [60.0, 60.0, 70.0, 90.0];
/// Width and height of the colour bar, and number of its rectangles.
const BAR: [f64; 2] = [400.0, 14.0];
const BAR_PARTS: usize = 40;
/// Colours of the largest share that adds to the error, and of the largest one that reduces it.
const RED: [f64; 3] = [178.0, 24.0, 43.0];
const BLUE: [f64; 3] = [33.0, 102.0, 172.0];

/// Draws the mesh; each element has the colour of the share of its region, in per cent of the error.
pub fn draw(map: &ErrorMap, mesh: &Mesh, title: &str) -> Drawing {
    let all: Vec<usize> = (0..mesh.elements.len()).filter(|&e| !mesh.elements[e].kind.is_discrete()).collect();
    let [low, high] = super::bounds(mesh, &all);
    let extent = [0, 1].map(|i| (high[i] - low[i]).max(f64::MIN_POSITIVE));
    // The longer side of the mesh is horizontal.
    let across = usize::from(extent[1] > extent[0]);
    let unit = (PLOT[0] / extent[across]).min(PLOT[1] / extent[1 - across]);
    let [left, right, top, bottom] = MARGIN;
    let width = (extent[across] * unit).max(BAR[0]) + left + right;
    let height = extent[1 - across] * unit + top + bottom;
    let place = |p: [f64; 2]| {
        let upwards = (p[1 - across] - low[1 - across]) * unit;
        [left + (p[across] - low[across]) * unit, height - bottom - upwards]
    };
    let mut drawing = Drawing::new([width.round(), height.round()]);
    drawing.label(TextLabel { size: 16.0, ..TextLabel::new([left, 28.0], TextAnchor::Start, title) });
    let shares: Vec<f64> = map.regions.iter().map(|r| 100.0 * r.share.unwrap_or(0.0) / map.error).collect();
    let largest = shares.iter().fold(f64::MIN_POSITIVE, |largest, share| share.abs().max(largest));
    let names = mesh.elements.iter().enumerate().map(|(at, element)| (&*element.name, at));
    let places: std::collections::HashMap<&str, usize> = names.collect();
    for (region, share) in map.regions.iter().zip(&shares) {
        let fill = if region.share.is_some() { colour(share / largest) } else { 0xdd_dd_dd };
        let paint = ShapePaint { stroke: Some(LineStroke::new(0x88_88_88, 0.4)), ..ShapePaint::fill(fill, 1.0) };
        for element in region.region.elements.iter().filter_map(|name| places.get(name.as_str())) {
            let nodes = &mesh.elements[*element].nodes;
            drawing.path(nodes.iter().map(|&n| place(mesh.points[n])), nodes.len() > 2, paint);
        }
    }
    for (region, share) in map.regions.iter().zip(&shares) {
        let [low, high] = region.bounds;
        let [x, y] = place([0, 1].map(|i| 0.5 * (low[i] + high[i])));
        let share = if region.share.is_some() { digits(*share, 2) } else { "?".into() };
        for (line, text) in [region.region.name.clone(), share].into_iter().enumerate() {
            let at = [x, y + 13.0 * line as f64];
            drawing.label(TextLabel { size: 11.0, ..TextLabel::new(at, TextAnchor::Middle, text) });
        }
    }
    draw_bar(&mut drawing, [left, height - 0.6 * bottom], largest);
    drawing
}

/// Draws the colour bar from its upper left corner.
fn draw_bar(drawing: &mut Drawing, [x, y]: [f64; 2], largest: f64) {
    let part = BAR[0] / BAR_PARTS as f64;
    for at in 0..BAR_PARTS {
        let value = (2 * at + 1) as f64 / BAR_PARTS as f64 - 1.0;
        drawing.rectangle([x + at as f64 * part, y], [part, BAR[1]], ShapePaint::fill(colour(value), 1.0));
    }
    let texts = [(0.0, format!("-{}", short(largest))), (0.5, "0".into()), (1.0, short(largest))];
    for (share, text) in texts {
        let at = [x + share * BAR[0], y + BAR[1] + 16.0];
        drawing.label(TextLabel { size: 12.0, ..TextLabel::new(at, TextAnchor::Middle, text) });
    }
    let at = [x, y - 6.0];
    let text = "share, % of the error: red regions add to the error, blue ones reduce it, grey ones have no result";
    drawing.label(TextLabel { size: 12.0, ..TextLabel::new(at, TextAnchor::Start, text) });
}

/// Returns a colour between blue (-1), white (0) and red (1).
fn colour(value: f64) -> Colour {
    let end = if value < 0.0 { BLUE } else { RED };
    let part = value.abs().min(1.0);
    end.iter().fold(0, |colour, channel| colour << 8 | (255.0 + part * (channel - 255.0)).round() as Colour)
}
