//! Explanations of the diagnostic codes of this folder (`D…`).

use revolve_numerics::codes;

use super::DiagnosticCode;

/// Diagnostic codes of reading a deck.
pub static CODES: &[DiagnosticCode] = codes! {
    "D001" "The deck cannot be read" "The file named on the command line does not exist or may not be read."
    "D002" "An included file cannot be read" "The file of *INCLUDE, INPUT= (or of a card's INPUT=) does not exist, may not be read or is encrypted. Names are relative to the file that includes; backslashes and quotes are understood."
    "D003" "A file includes itself" "Following the *INCLUDE lines leads back to a file that is still being read."
    "D004" "Too many includes" "Includes are nested deeper than 32 or more than 2000 files are read. This is nearly always a mistake."
    "D005" "Not a text file" "The file holds zero bytes. Decks are UTF-8, UTF-16 with byte-order mark, or latin-1 text."
    "D006" "Deck too large" "All files together hold more than 2 GiB. Large meshes are better read with *MESH."
    "D007" "*INCLUDE without file" "*INCLUDE needs INPUT=file."
    "D008" "File found at another path" "The given path does not exist; a file of the same name in the folder of the deck is read instead."
    "D009" "Empty deck" "The file has no keyword line; it is empty or has only blank lines and comments."
    "D010" "Input file of another program" "The file begins like an input file of LS-DYNA (*KEYWORD) or OpenRadioss (#RADIOSS STARTER, /BEGIN). Decks have the syntax of ABAQUS/Explicit: convert the file with a pre-processor."
    "D011" "file outside the folder of the deck" "With `--untrusted` or REVOLVE_UNTRUSTED=1, *INCLUDE, INPUT= and *MESH read only files in the folder of the deck and below it. Symbolic links are followed first."
    "D101" "Unknown keyword" "The word after the star is neither a known keyword of ABAQUS/Explicit (docs/abaqus.md) nor an extension of Revolve. Case and blanks are ignored; unambiguous abbreviations are accepted. The data lines of the card are skipped."
    "D102" "Ambiguous keyword" "The word after the star is an abbreviation of several keywords. Write more letters."
    "D103" "Unknown parameter" "The keyword has no parameter of this name. `revolve explain KEYWORD` lists its parameters."
    "D104" "Ambiguous parameter" "The word is an abbreviation of several parameters of the keyword. Write more letters."
    "D105" "Parameter without value" "An equals sign must be followed by a value."
    "D106" "Parameter given twice" "A parameter may be given only once on a keyword line."
    "D107" "Data before any keyword" "The deck begins with a line that is neither a keyword line (`*`) nor a comment (`**`)."
    "D108" "Quote not closed" "A quote must be closed on the line that opens it."
    "D109" "Comment of another program" "A line begins with `$` or `#`, the comment signs of LS-DYNA and OpenRadioss. Comments of decks begin with `**`. The line is skipped; only the first one is reported."
    "D201" "Unsupported keyword" "The keyword is known but not supported, and the result would be different without it. It is an error, so that no wrong result is computed."
    "D301" "Not a number" "A field must be a number, for example `1`, `1.`, `.5`, `1e-3` or `1.57d0`."
    "D302" "Letter in a number" "A number contains a letter that looks like a digit (o for 0, l for 1)."
    "D303" "Number too large" "A number must be finite; the largest is about 1.8e308."
    "D304" "Not a whole number" "A field must be a whole number."
    "D401" "Undefined parameter" "`<name>` is used before a *PARAMETER line defines it, or is not defined. Names of parameters are case-sensitive."
    "D402" "Parameter without value" "The expression of a *PARAMETER line cannot be read or evaluated. Allowed are + - * / // % **, parentheses, sqrt sin cos tan asin acos atan atan2 exp log log10 abs min max int float round pow, pi, and text in quotes. `/` is true division."
    "D403" "Override of an undefined parameter" "`--set NAME=VALUE` replaces a *PARAMETER definition; the deck defines no parameter of this name."
    "D404" "Bad parameter definition" "The lines of a *PARAMETER block are `name = expression`."
    "D405" "Unsupported form of *PARAMETER" "Tabulated and dependent parameters are not supported."
    "D407" "Bad override" "`--set NAME=VALUE` takes an expression as on *PARAMETER lines, and it must have a finite value."
    "D408" "Bad mesh refinement" "`--mesh-refine` and the setting `mesh` divide each edge of the mesh into this number of equal parts, a whole number from 1 to 1000. `mesh=1/2` merges two by two elements, `mesh=1/3` three by three. A *PARAMETER of the name `mesh` takes precedence over the setting. `--curved` and the setting `mesh-curved` give the angle in degrees, above 0 and up to 60, by which smooth boundaries of a refined mesh turn at most at a node."
};

/// Returns the explanation of a code; case is ignored.
pub fn find_code(code: &str) -> Option<&'static DiagnosticCode> {
    CODES.iter().find(|c| c.code.eq_ignore_ascii_case(code.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns all codes (`D` and three digits) that are string literals in a source text.
    fn codes_in(text: &str) -> Vec<&str> {
        let is_code = |s: &&str| s.len() == 4 && s.starts_with('D') && s[1..].bytes().all(|b| b.is_ascii_digit());
        text.split('"').filter(is_code).collect()
    }

    #[test]
    fn every_code_is_explained_and_used() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("deck");
        let mut known_codes = std::collections::BTreeSet::new();
        for entry in std::fs::read_dir(folder).expect("source folder") {
            let path = entry.expect("entry").path();
            if path.is_file() && path.file_name().is_some_and(|n| n != "codes.rs") {
                let text = std::fs::read_to_string(path).expect("source");
                known_codes.extend(codes_in(&text).into_iter().map(str::to_owned));
            }
        }
        assert_eq!(known_codes, CODES.iter().map(|c| c.code.to_owned()).collect());
    }
}
