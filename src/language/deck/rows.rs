//! Data lines of long listings (nodes, elements, members of sets). To save memory they are kept as text and split on
//! demand.

use std::borrow::Cow;

use super::lexer;
use super::number::parse_number;
use super::source::{Sources, Span};
use super::syntax::{Card, DataLine, ListingRow};

/// Cards whose data lines are stored in [`Card::rows`].
const LISTINGS: [&str; 4] = ["NODE", "ELEMENT", "NSET", "ELSET"];

/// Returns whether a keyword is a listing of nodes, elements or members of a set.
pub(super) fn is_listing(keyword: &str) -> bool {
    LISTINGS.contains(&keyword)
}

impl ListingRow {
    /// Returns the span of the line.
    pub fn span(&self) -> Span {
        match self {
            ListingRow::Text(span) => *span,
            ListingRow::Line(line) => line.span,
        }
    }

    /// Returns the text of a plain line; `None` for other lines.
    pub fn text<'s>(&self, sources: &'s Sources) -> Option<&'s str> {
        match self {
            ListingRow::Text(span) => Some(sources.text(*span)),
            ListingRow::Line(_) => None,
        }
    }

    /// Returns the number of fields. A trailing comma adds no field.
    pub fn field_count(&self, sources: &Sources) -> usize {
        match self {
            ListingRow::Text(span) => {
                let text = sources.text(*span);
                let commas = text.bytes().filter(|b| *b == b',').count();
                commas + usize::from(commas == 0 || !text.ends_with(','))
            }
            ListingRow::Line(line) => line.fields.len(),
        }
    }

    /// Returns the line split into words.
    pub fn line(&self, sources: &Sources) -> Cow<'_, DataLine> {
        match self {
            ListingRow::Text(span) => {
                let text = sources.file(*span).map_or("", |file| &file.text);
                let fields = lexer::split(text, span.start as usize..span.end as usize).ranges;
                let fields = fields.into_iter().map(|range| lexer::word(text, span.file, range)).collect();
                Cow::Owned(DataLine { fields, span: *span })
            }
            ListingRow::Line(line) => Cow::Borrowed(line),
        }
    }
}

/// Iterates over the non-empty fields of a line.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|field| !field.is_empty())
}

/// Parses a label and two coordinates, ignoring further fields; `None` if the line does not begin with these.
pub fn label_and_coordinates(text: &str) -> Option<(i64, [f64; 2])> {
    let mut fields = text.split(',').map(str::trim);
    let label = fields.next()?.parse().ok()?;
    Some((label, [parse_number(fields.next()?).ok()?, parse_number(fields.next()?).ok()?]))
}

impl Card {
    /// Iterates over all data lines, including those of listings.
    pub fn data<'c>(&'c self, sources: &'c Sources) -> impl Iterator<Item = Cow<'c, DataLine>> {
        let rows = self.rows.iter().map(|row| row.line(sources));
        self.lines.iter().map(Cow::Borrowed).chain(rows)
    }

    /// Returns the number of data lines, including those of listings.
    pub fn line_count(&self) -> usize {
        self.lines.len() + self.rows.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{label_and_coordinates, words};
    use crate::deck::read_text;

    #[test]
    fn rows_of_listings_split_as_other_data_lines() {
        let lines = ["1, 2.,\t3", " 1, 2,", ", 8e-05", ",", ",,", "7", "1, \"a, b\", c", "<n>, <n>,"];
        let text = format!("*PARAMETER\nn = 3\n*NSET, NSET=A\n{}\n", lines.join("\n"));
        let (deck, _) = read_text("rows.inp", &text, &[]);
        let card = &deck.cards[0];
        assert_eq!((card.lines.len(), card.rows.len(), card.line_count()), (0, lines.len(), lines.len()));
        // The same lines on a card that is not a listing.
        let (other, _) = read_text("rows.inp", &text.replace("*NSET, NSET=A", "*BOUNDARY    "), &[]);
        for (row, line) in card.rows.iter().zip(&other.cards[0].lines) {
            assert_eq!(format!("{:?}", row.line(&deck.sources)), format!("{line:?}"));
            assert_eq!((row.field_count(&deck.sources), row.span()), (line.fields.len(), line.span));
        }
    }

    #[test]
    fn labels_and_coordinates_are_parsed() {
        assert_eq!(label_and_coordinates(" 12, 1.5,\t-2.d-3"), Some((12, [1.5, -2e-3])));
        assert_eq!(label_and_coordinates("12, 1., 2., 3."), Some((12, [1.0, 2.0])));
        for text in ["12, 1.5", "1.2, 1., 2.", "12, , 2.", "12, 1.o, 2.", ""] {
            assert_eq!(label_and_coordinates(text), None, "{text}");
        }
        assert!(words(" 1,, 2 ,").eq(["1", "2"]));
    }
}
