//! The place of a position in a deck: its card, and the part of the card.

use crate::deck::keywords::{DataShape, InputRule, Keyword, NameLookup, find_keyword, find_parameter, is_parameter};
use crate::deck::lexer::{self, LineKind, kind, split};
use crate::text::{ColumnEncoding, TextBuffer, TextPosition, TextRange};

/// Largest number of data lines that are read to find the layout of a line.
const MOST_LINES: u32 = 4000;

/// A card as far as a place in it needs it.
#[derive(Debug)]
pub struct CardContext {
    /// Row of the keyword table; `None` for an unknown keyword.
    pub keyword: Option<&'static Keyword>,
    pub parameters: Vec<WrittenParameter>,
    /// The part of the card at the position.
    pub part: CardPart,
}

#[derive(Clone, Debug)]
pub struct WrittenParameter {
    /// Rule of the keyword table.
    pub rule: Option<&'static InputRule>,
    pub name_range: TextRange,
    /// Value as written, with its range.
    pub value: Option<(String, TextRange)>,
}

#[derive(Debug)]
pub enum CardPart {
    /// The keyword with its star.
    Keyword(TextRange),
    ParameterName(TextRange),
    /// The value of the parameter with this index.
    ParameterValue(usize, TextRange),
    /// A field of a data line.
    Field {
        /// Its rule; `None` if the card has no such field.
        rule: Option<&'static InputRule>,
        range: TextRange,
    },
    /// A comment, or text before the first keyword.
    Comment,
}

/// A keyword line with its continuation lines.
pub struct KeywordLine {
    /// Row of the keyword table.
    pub keyword: Option<&'static Keyword>,
    /// Range of the keyword with its star.
    pub range: TextRange,
    pub parameters: Vec<WrittenParameter>,
    /// The line after the last continuation line.
    pub end: u32,
}

impl KeywordLine {
    /// Reads the keyword line at a line.
    pub fn read(buffer: &TextBuffer, line: u32, encoding: ColumnEncoding) -> KeywordLine {
        let text = buffer.line(line);
        let fields = split(text, 0..text.len());
        let star = fields.ranges.first().cloned().unwrap_or(lexer::trim(text, 0..text.len()));
        let name = text.get(star.start + 1..star.end).unwrap_or_default();
        let keyword = match find_keyword(name) {
            NameLookup::Found(keyword) => Some(keyword),
            _ => None,
        };
        let mut read =
            KeywordLine { keyword, range: range(text, line, star, encoding), parameters: Vec::new(), end: line + 1 };
        read.add_parameters(text, line, fields.ranges.into_iter().skip(1), encoding);
        let mut continued = fields.trailing_comma;
        let mut next = line + 1;
        while continued && next < buffer.line_count() {
            let text = buffer.line(next);
            if matches!(kind(text), LineKind::Blank | LineKind::Comment) {
                next += 1;
                continue;
            }
            let fields = split(text, 0..text.len());
            if !read.is_continuation(text, &fields.ranges) {
                break;
            }
            continued = fields.trailing_comma;
            read.add_parameters(text, next, fields.ranges.into_iter(), encoding);
            next += 1;
            read.end = next;
        }
        read
    }

    /// Returns whether a line has only parameters.
    fn is_continuation(&self, text: &str, ranges: &[std::ops::Range<usize>]) -> bool {
        let is_written = |range: &std::ops::Range<usize>| match lexer::equals_sign(text, range.clone()) {
            Some(at) => text[range.start..at].starts_with(char::is_alphabetic),
            None => self.keyword.is_some_and(|keyword| is_parameter(keyword, &text[range.clone()])),
        };
        kind(text) == LineKind::Data && !ranges.is_empty() && ranges.iter().filter(|r| !r.is_empty()).all(is_written)
    }

    fn add_parameters(
        &mut self,
        text: &str,
        line: u32,
        ranges: impl Iterator<Item = std::ops::Range<usize>>,
        encoding: ColumnEncoding,
    ) {
        for field in ranges.filter(|range| !range.is_empty()) {
            let equals = lexer::equals_sign(text, field.clone());
            let name = lexer::trim(text, field.start..equals.unwrap_or(field.end));
            let rule = self.keyword.and_then(|keyword| match find_parameter(keyword, &text[name.clone()]) {
                NameLookup::Found(rule) => Some(rule),
                _ => None,
            });
            let value = equals.map(|at| lexer::trim(text, at + 1..field.end));
            self.parameters.push(WrittenParameter {
                rule,
                name_range: range(text, line, name, encoding),
                value: value.map(|at| (text[at.clone()].to_owned(), range(text, line, at, encoding))),
            });
        }
    }

    /// Returns the layout of the data lines.
    pub fn shape(&self) -> &'static DataShape {
        let Some(keyword) = self.keyword else { return &DataShape::Nothing };
        keyword.shape(|name| {
            let written = self.parameters.iter().find(|p| p.rule.is_some_and(|rule| rule.name == name))?;
            let value = written.value.as_ref().map(|(text, _)| text.trim_matches('"'));
            let is_off = value.is_some_and(|text| written.rule.is_some_and(|rule| rule.value.is_off(text)));
            (!is_off).then_some(value)
        })
    }
}

/// Returns the range of bytes of a line.
pub fn range(text: &str, line: u32, bytes: std::ops::Range<usize>, encoding: ColumnEncoding) -> TextRange {
    let start = encoding.width(&text[..bytes.start]);
    TextRange::on_line(line, start, start + encoding.width(&text[bytes]))
}

/// Finds the place of a position.
pub fn card_context(buffer: &TextBuffer, position: TextPosition, encoding: ColumnEncoding) -> CardContext {
    let text = buffer.line(position.line);
    let none = |part| CardContext { keyword: None, parameters: Vec::new(), part };
    if kind(text) == LineKind::Comment {
        return none(CardPart::Comment);
    }
    let Some(first) = buffer.keyword_line_at(position.line) else { return none(CardPart::Comment) };
    let head = KeywordLine::read(buffer, first, encoding);
    let part = if position.line < head.end || continues_at(&head, buffer, position.line) {
        keyword_part(&head, buffer, position, encoding)
    } else {
        field_part(&head, buffer, position, encoding)
    };
    CardContext { keyword: head.keyword, parameters: head.parameters, part }
}

/// Returns whether a line continues a keyword line that ends with a comma, although it is empty or begun.
fn continues_at(head: &KeywordLine, buffer: &TextBuffer, line: u32) -> bool {
    let is_open = buffer.line(head.end - 1).trim_end().ends_with(',');
    let begun = buffer.line(line).trim_start();
    is_open && line == head.end && begun.starts_with(char::is_alphabetic)
}

fn keyword_part(head: &KeywordLine, buffer: &TextBuffer, position: TextPosition, encoding: ColumnEncoding) -> CardPart {
    if position.line == head.range.start.line && position <= head.range.end {
        return CardPart::Keyword(head.range);
    }
    for (index, parameter) in head.parameters.iter().enumerate() {
        if parameter.name_range.touches(position) {
            return CardPart::ParameterName(parameter.name_range);
        }
        if let Some((_, value)) = &parameter.value
            && value.touches(position)
        {
            return CardPart::ParameterValue(index, *value);
        }
    }
    // Between words: after an equals sign a value begins, after a comma a name.
    let text = buffer.line(position.line);
    let text_before = &text[..encoding.byte(text, position.character)];
    let empty_range = TextRange { start: position, end: position };
    let value = text_before.rsplit(',').next().and_then(|field| field.split_once('='));
    let of_value = value.and_then(|_| head.parameters.iter().rposition(|p| p.name_range.end <= position));
    of_value.map_or(CardPart::ParameterName(empty_range), |index| CardPart::ParameterValue(index, empty_range))
}

fn field_part(head: &KeywordLine, buffer: &TextBuffer, position: TextPosition, encoding: ColumnEncoding) -> CardPart {
    let shape = head.shape();
    let text = buffer.line(position.line);
    let byte = encoding.byte(text, position.character);
    let commas = split(text, 0..byte);
    let column = commas.ranges.len() - usize::from(!commas.trailing_comma && !commas.ranges.is_empty());
    let fields = split(text, 0..text.len());
    let empty_range = TextRange { start: position, end: position };
    let field_range = fields.ranges.get(column).filter(|range| range.start <= byte && byte <= range.end);
    let (row, values_before) = row_of(head, shape, buffer, position.line);
    CardPart::Field {
        rule: shape.field(row, column, values_before),
        range: field_range.map_or(empty_range, |bytes| range(text, position.line, bytes.clone(), encoding)),
    }
}

/// Returns the number of a data line in its card, and the number of values before it in its record.
fn row_of(head: &KeywordLine, shape: &DataShape, buffer: &TextBuffer, line: u32) -> (usize, usize) {
    let (mut row, mut values_before) = (0, 0);
    let first = head.end.max(line.saturating_sub(MOST_LINES));
    row += (first - head.end) as usize;
    for at in first..line {
        let text = buffer.line(at);
        if kind(text) == LineKind::Data {
            values_before = shape.values_after(values_before, split(text, 0..text.len()).ranges.len());
            row += 1;
        }
    }
    (row, values_before)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DECK: &str =
        "*Material, name=A\n*Plastic, hardening=JOHNSON COOK,\n rate=1\n 1., 2., 3.\n*Boundary\nS, 1, 2\n";

    fn part(line: u32, character: u32) -> String {
        let context = card_context(&TextBuffer::new(DECK), TextPosition { line, character }, ColumnEncoding::Utf16);
        let keyword = context.keyword.map_or("", |k| k.name);
        match context.part {
            CardPart::Keyword(_) => format!("{keyword} keyword"),
            CardPart::ParameterName(_) => format!("{keyword} name"),
            CardPart::ParameterValue(index, _) => {
                format!("{keyword} value of {}", context.parameters[index].rule.map_or("", |rule| rule.name))
            }
            CardPart::Field { rule, .. } => format!("{keyword} field {}", rule.map_or("", |rule| rule.name)),
            CardPart::Comment => "comment".into(),
        }
    }

    #[test]
    fn places_are_found() {
        assert_eq!(part(0, 3), "MATERIAL keyword");
        assert_eq!(part(0, 12), "MATERIAL name");
        assert_eq!(part(0, 17), "MATERIAL value of NAME");
        assert_eq!(part(1, 25), "PLASTIC value of HARDENING");
        assert_eq!(part(2, 2), "PLASTIC name");
        assert_eq!(part(3, 6), "PLASTIC field B");
        assert_eq!(part(5, 0), "BOUNDARY field node or set");
        assert_eq!(part(5, 4), "BOUNDARY field first degree of freedom");
    }
}
