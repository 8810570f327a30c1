//! The codes of the deck room's diagnostics, explained.
//! Never here: codes of other rooms.

use super::Code;

/// A list of codes, each with title and text.
macro_rules! codes {
    ($($code:literal $title:literal $text:literal)*) => {
        &[$($crate::deck::Code { code: $code, title: $title, text: $text }),*]
    };
}

/// Every code this room gives.
pub static CODES: &[Code] = codes! {
    "D001" "The deck cannot be read" "The file named on the command line does not exist or may not be read."
    "D002" "An included file cannot be read" "The file of *INCLUDE, INPUT= (or of a card's INPUT=) does not exist, may not be read or is encrypted. Names are relative to the file that includes; backslashes and quotes are understood."
    "D003" "A file includes itself" "Following the *INCLUDE lines leads back to a file that is still being read."
    "D004" "Too many includes" "Includes are nested deeper than 32 or more than 2000 files are read. This is nearly always a slip."
    "D005" "Not a text file" "The file holds zero bytes. Decks are UTF-8, UTF-16 with byte-order mark, or latin-1 text."
    "D006" "Deck too large" "All files together hold more than 2 GiB. Large meshes are better read with *MESH."
    "D007" "*INCLUDE without file" "*INCLUDE needs INPUT=file."
    "D008" "A file of another path" "The path of the file does not exist here; a file of the same name beside the deck is read instead."
    "D009" "Empty deck" "The file holds no keyword: nothing, or blank lines and comments alone."
    "D101" "Unknown keyword" "The word after the star is no keyword of ABAQUS/Explicit that is known to Revolve (docs/abaqus.md) and no extension. Case and blanks do not count; unambiguous abbreviations are understood. Its data lines are skipped."
    "D102" "Ambiguous keyword" "The word after the star abbreviates several keywords. Write more of it."
    "D103" "Unknown parameter" "The keyword has no parameter of that name. `revolve explain KEYWORD` lists those it has."
    "D104" "Ambiguous parameter" "The word abbreviates several parameters of the keyword. Write more of it."
    "D105" "Parameter without value" "An equals sign must be followed by a value."
    "D106" "Parameter given twice" "A keyword line may give a parameter once."
    "D107" "Data before any keyword" "The deck begins with a line that is neither keyword (`*`) nor comment (`**`)."
    "D108" "Quote not closed" "A quote must be closed on the line that opens it."
    "D201" "Unsupported keyword" "The keyword is known but not supported, and without it the answer would be another one. The deck is refused instead of being misread."
    "D301" "Not a number" "A field that must be a number is none. Accepted are `1`, `1.`, `.5`, `1e-3`, `1.57d0`."
    "D302" "Letter in a number" "A field would be a number but for a letter that looks like a digit (o and 0, l and 1)."
    "D303" "Number too large" "A number must be finite; the largest is about 1.8e308."
    "D304" "Not a whole number" "A field that must be a whole number is none."
    "D401" "Undefined parameter" "A `<name>` refers to no parameter defined above it. Names of parameters are case-sensitive."
    "D402" "Parameter without value" "The expression of a *PARAMETER line cannot be read or evaluated. Known are + - * / // % **, parentheses, sqrt sin cos tan asin acos atan atan2 exp log log10 abs min max int float round pow, pi, and text in quotes. `/` is true division."
    "D403" "Override of nothing" "`--set NAME=VALUE` replaces a *PARAMETER definition; the deck has none of that name."
    "D404" "Bad parameter definition" "The lines of a *PARAMETER block are `name = expression`."
    "D405" "Unsupported form of *PARAMETER" "Tabulated and dependent parameters are not supported."
    "D407" "Bad override" "The value of `--set NAME=VALUE` is an expression like those of *PARAMETER lines and must have a value."
};

/// The explanation of a code, whatever its case.
pub fn find_code(code: &str) -> Option<&'static Code> {
    CODES.iter().find(|c| c.code.eq_ignore_ascii_case(code.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All `"D123"` in a source text.
    fn codes_in(text: &str) -> Vec<&str> {
        let is_code = |s: &&str| s.len() == 4 && s.starts_with('D') && s[1..].bytes().all(|b| b.is_ascii_digit());
        text.split('"').filter(is_code).collect()
    }

    #[test]
    fn every_code_is_explained_and_given() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/deck");
        let mut given = std::collections::BTreeSet::new();
        for entry in std::fs::read_dir(folder).expect("source folder") {
            let path = entry.expect("entry").path();
            if path.is_file() && path.file_name().is_some_and(|n| n != "codes.rs") {
                let text = std::fs::read_to_string(path).expect("source");
                given.extend(codes_in(&text).into_iter().map(str::to_owned));
            }
        }
        assert_eq!(given, CODES.iter().map(|c| c.code.to_owned()).collect());
    }
}
