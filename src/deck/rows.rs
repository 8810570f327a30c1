//! Rows of long listings: nodes, elements and members stand in the text alone until somebody asks for them.
//! Never here: what they list.

use std::borrow::Cow;

use super::lexer;
use super::number::parse_number;
use super::source::{Sources, Span};
use super::syntax::{Card, DataLine, Row};

/// Cards whose data lines are [`Card::rows`].
const LISTINGS: [&str; 4] = ["NODE", "ELEMENT", "NSET", "ELSET"];

/// Whether a card, by its keyword, lists nodes, elements or members.
pub(super) fn is_listing(keyword: &str) -> bool {
    LISTINGS.contains(&keyword)
}

impl Row {
    /// Whether a line, blanks at its ends aside, is its text and nothing else.
    pub(super) fn is_plain(text: &str) -> bool {
        !text.bytes().any(|b| b == b'<' || b == b'"')
    }

    /// The whole line.
    pub fn span(&self) -> Span {
        match self {
            Row::Text(span) => *span,
            Row::Line(line) => line.span,
        }
    }

    /// The text, of one that is nothing else.
    pub fn text<'s>(&self, sources: &'s Sources) -> Option<&'s str> {
        match self {
            Row::Text(span) => Some(sources.text(*span)),
            Row::Line(_) => None,
        }
    }

    /// How many fields it has: a trailing comma gives no extra field.
    pub fn field_count(&self, sources: &Sources) -> usize {
        match self {
            Row::Text(span) => {
                let text = sources.text(*span);
                let commas = text.bytes().filter(|b| *b == b',').count();
                commas + usize::from(commas == 0 || !text.ends_with(','))
            }
            Row::Line(line) => line.fields.len(),
        }
    }

    /// The line with its words.
    pub fn line(&self, sources: &Sources) -> Cow<'_, DataLine> {
        match self {
            Row::Text(span) => {
                let text = sources.file(*span).map_or("", |file| &file.text);
                let fields = lexer::split(text, span.start as usize..span.end as usize).ranges;
                let fields = fields.into_iter().map(|range| lexer::word(text, span.file, range)).collect();
                Cow::Owned(DataLine { fields, span: *span })
            }
            Row::Line(line) => Cow::Borrowed(line),
        }
    }
}

/// The fields of a row's text that are not empty.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|field| !field.is_empty())
}

/// A label and two coordinates, whatever follows; `None` of anything else.
pub fn label_and_place(text: &str) -> Option<(i64, [f64; 2])> {
    let mut fields = text.split(',').map(str::trim);
    let label = fields.next()?.parse().ok()?;
    Some((label, [parse_number(fields.next()?).ok()?, parse_number(fields.next()?).ok()?]))
}

impl Card {
    /// The data lines, of listings as well.
    pub fn data<'c>(&'c self, sources: &'c Sources) -> impl Iterator<Item = Cow<'c, DataLine>> {
        let rows = self.rows.iter().map(|row| row.line(sources));
        self.lines.iter().map(Cow::Borrowed).chain(rows)
    }

    /// How many data lines there are.
    pub fn line_count(&self) -> usize {
        self.lines.len() + self.rows.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{label_and_place, words};
    use crate::deck::read_text;

    #[test]
    fn a_row_is_the_line_that_it_stands_for() {
        let lines = ["1, 2.,\t3", " 1, 2,", ", 8e-05", ",", ",,", "7", "1, \"a, b\", c", "<n>, <n>,"];
        let text = format!("*PARAMETER\nn = 3\n*NSET, NSET=A\n{}\n", lines.join("\n"));
        let (deck, _) = read_text("rows.inp", &text, &[]);
        let card = &deck.cards[0];
        assert_eq!((card.lines.len(), card.rows.len(), card.line_count()), (0, lines.len(), lines.len()));
        // The same lines below a card that is no listing.
        let (other, _) = read_text("rows.inp", &text.replace("*NSET, NSET=A", "*BOUNDARY    "), &[]);
        for (row, line) in card.rows.iter().zip(&other.cards[0].lines) {
            assert_eq!(format!("{:?}", row.line(&deck.sources)), format!("{line:?}"));
            assert_eq!((row.field_count(&deck.sources), row.span()), (line.fields.len(), line.span));
        }
    }

    #[test]
    fn numbers_of_a_row() {
        assert_eq!(label_and_place(" 12, 1.5,\t-2.d-3"), Some((12, [1.5, -2e-3])));
        assert_eq!(label_and_place("12, 1., 2., 3."), Some((12, [1.0, 2.0])));
        for text in ["12, 1.5", "1.2, 1., 2.", "12, , 2.", "12, 1.o, 2.", ""] {
            assert_eq!(label_and_place(text), None, "{text}");
        }
        assert!(words(" 1,, 2 ,").eq(["1", "2"]));
    }
}
