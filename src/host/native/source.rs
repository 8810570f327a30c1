//! Prepares user files that other Fortran compilers accept for gfortran: includes in another case or folder,
//! `#include '…'`, omitted arguments of `xplb_abqerr`, logicals compared with `==`. Messages keep file names and line
//! numbers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use revolve_diagnostics::{files, printable};

/// A user file and its includes, as they are compiled.
pub struct PreparedSource {
    /// Changed texts, by path relative to the folder of the file; the file itself has an empty path.
    changed: BTreeMap<String, String>,
}

/// Folders in which an include is searched.
#[derive(Clone, Copy)]
struct IncludePlace<'a> {
    /// Folder of the file that is compiled.
    main: &'a Path,
    /// Folder of the file with the include line.
    here: &'a Path,
    /// Includes that the program provides.
    known: &'a [String],
}

/// Returns the paths at which compilers search an include: the folder of the including file, then that of the compiled
/// file.
pub fn candidates(main: &Path, here: &Path, name: &str) -> [PathBuf; 2] {
    [here.join(name), main.join(name)]
}

impl PreparedSource {
    /// Reads a file and its includes; `known` are the includes that the program provides.
    pub fn read(file: &Path, known: &[String]) -> PreparedSource {
        let mut source = PreparedSource { changed: BTreeMap::new() };
        source.take(file, "", folder_of(file), known, 0);
        source
    }

    /// Returns the texts of the files that were changed for compilation.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.changed.values().map(String::as_str)
    }

    fn take(&mut self, file: &Path, name: &str, main: &Path, known: &[String], depth: usize) {
        let Ok(bytes) = files::read(file) else { return };
        let text = String::from_utf8_lossy(&bytes);
        let new = ready(&text, file, IncludePlace { main, here: folder_of(file), known });
        // Prepared lines contain paths relative to the folder of the compiled file.
        for inner in new.lines().filter_map(included).filter(|_| depth < 9) {
            let path = main.join(inner);
            if !Path::new(inner).is_absolute() && path.is_file() && !self.changed.contains_key(inner) {
                self.take(&path, inner, main, known, depth + 1);
            }
        }
        if new != text {
            self.changed.insert(name.to_owned(), marker(file) + &new);
        }
    }

    /// Returns the file to compile: that of the user, or a changed copy in `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn write(&self, file: &Path, folder: &Path) -> std::io::Result<PathBuf> {
        if self.changed.is_empty() {
            return Ok(file.to_owned());
        }
        std::fs::create_dir_all(folder)?;
        for (name, text) in self.changed.iter().filter(|(name, _)| !name.is_empty() && !name.contains("..")) {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
            std::fs::write(path, text)?;
        }
        let own_text = match self.changed.get("") {
            Some(text) => text.clone(),
            None => marker(file) + &String::from_utf8_lossy(&files::read(file)?),
        };
        let path = folder.join(file.file_name().unwrap_or_default());
        std::fs::write(&path, own_text)?;
        Ok(path)
    }
}

/// Returns the file name in an `include 'name'` or `#include "name"` line.
pub fn included(line: &str) -> Option<&str> {
    let line = line.trim().trim_start_matches('#').trim_start();
    let quoted = line.get(..7).filter(|w| w.eq_ignore_ascii_case("include")).map(|_| line[7..].trim_start())?;
    let quote = quoted.chars().next().filter(|c| matches!(c, '\'' | '"' | '<'))?;
    let end = if quote == '<' { '>' } else { quote };
    quoted[1..].split(end).next()
}

/// Returns the folder of a file, empty for the working folder.
fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// Returns the text of a file as it is passed to the compiler.
fn ready(text: &str, file: &Path, place: IncludePlace<'_>) -> String {
    let mut lines: Vec<String> = text.lines().map(|line| logical(include_line(line, place))).collect();
    bring_header_inside(&mut lines, file);
    let mut new = lines.join("\n");
    if text.ends_with('\n') {
        new.push('\n');
    }
    let same = new == text || text.contains("\r\n") && new == text.replace("\r\n", "\n");
    fill_arguments(if same { text.to_owned() } else { new })
}

/// Header with the functions for arrays and threads.
pub const HEADER: &str = "SMAAspUserSubroutines.hdr";

/// Moves a header from above the first subroutine, where it declares nothing, to after the includes of each subroutine.
fn bring_header_inside(lines: &mut Vec<String>, file: &Path) {
    let lower = |line: &String| line.trim_start().to_lowercase();
    let begins = |line: &String| {
        let line = lower(line);
        ["subroutine ", "function ", "module ", "program ", "recursive "].iter().any(|w| line.starts_with(w))
            || line.contains(" function ") && !line.starts_with(['!', 'c', '*'])
    };
    let end = lines.iter().position(begins).unwrap_or(0);
    let is_header = |line: &String| line.starts_with('#') && included(line).is_some_and(|n| n.starts_with("SMAAsp"));
    if !lines[..end].iter().any(is_header) {
        return;
    }
    let taken = lines[..end].iter_mut().filter(|line| is_header(line));
    taken.for_each(String::clear);
    let mut new = Vec::with_capacity(lines.len() + 8);
    for (i, line) in lines.drain(..).enumerate() {
        let inside = included(&line).is_some_and(|n| n.to_lowercase().contains("aba_param"));
        new.push(line);
        if inside {
            new.push(format!("#include \"{HEADER}\""));
            new.push(format!("# {} \"{}\"", i + 2, file.display()));
        }
    }
    *lines = new;
}

/// Returns an include line with the name of an existing file; other lines are unchanged.
fn include_line(line: &str, place: IncludePlace<'_>) -> String {
    let line = line.strip_suffix('\r').unwrap_or(line);
    let Some(name) = included(line) else { return line.to_owned() };
    let file = found(name, place).unwrap_or_else(|| name.to_owned());
    if line.trim_start().starts_with('#') {
        // The preprocessor's `#include` allows double quotes and angle brackets only.
        let angle = line.contains('<');
        let (open, close) = if angle { ('<', '>') } else { ('"', '"') };
        return format!("#include {open}{file}{close}");
    }
    line.replacen(name, &file, 1)
}

/// Returns the line with `.eqv.` in place of `==` next to `.true.` or `.false.`, as gfortran requires.
fn logical(line: String) -> String {
    let lower = line.to_ascii_lowercase();
    if !(lower.contains(".true.") || lower.contains(".false.")) || lower.starts_with(['c', '*', '!']) {
        return line;
    }
    let end = |text: &str| text.trim_end().len();
    let mut changes = Vec::new();
    for (operator, instead) in [("==", ".eqv."), (".eq.", ".eqv."), ("/=", ".neqv."), (".ne.", ".neqv.")] {
        for (at, _) in lower.match_indices(operator) {
            let (left_side, after) = (&lower[..at], lower[at + operator.len()..].trim_start());
            let next_to = |word: &str| after.starts_with(word) || left_side[..end(left_side)].ends_with(word);
            // Not inside a string or a comment.
            let is_code = left_side.matches('\'').count() % 2 == 0 && left_side.matches('"').count() % 2 == 0;
            if is_code && !left_side.contains('!') && (next_to(".true.") || next_to(".false.")) {
                changes.push((at, operator.len(), instead));
            }
        }
    }
    changes.sort_unstable();
    let mut new = line;
    for (at, length, instead) in changes.into_iter().rev() {
        new.replace_range(at..at + length, instead);
    }
    new
}

/// Returns the line directive that names the file of the following text.
fn marker(file: &Path) -> String {
    format!("# 1 \"{}\"\n", printable(&file.to_string_lossy()).replace(['\\', '"', '\n'], "_"))
}

/// Returns the path of an include relative to the compiled file, if it differs from the written one. The include is
/// searched as written, in another case, or by its last component; in the folder of the line, in that of the compiled
/// file, or among the known ones.
fn found(name: &str, IncludePlace { main, here, known }: IncludePlace<'_>) -> Option<String> {
    let from_main = |path: PathBuf| {
        let short = path.strip_prefix(main).unwrap_or(&path).to_string_lossy().into_owned();
        (short != name).then_some(short)
    };
    if let Some(there) = candidates(main, here, name).into_iter().find(|path| path.is_file()) {
        return from_main(there);
    }
    if known.iter().any(|k| k == name) {
        return None;
    }
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let alike = |n: &String| n.eq_ignore_ascii_case(last);
    let folders = candidates(main, here, name).map(|path| folder_of(&path).to_owned());
    for folder in folders.iter().map(PathBuf::as_path).chain([here, main]) {
        let entries = std::fs::read_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let names = entries.into_iter().flatten().filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        if let Some(there) = names.filter(alike).max() {
            return from_main(folder.join(there));
        }
    }
    known.iter().filter(|n| alike(n)).max().cloned()
}

/// Values for omitted arguments of `xplb_abqerr`.
const FILLERS: [&str; 5] = ["-1", "' '", "0", "0.d0", "' '"];

/// Returns the text with all arguments of `call xplb_abqerr(lop, text, , , )`, which gfortran requires.
fn fill_arguments(text: String) -> String {
    let lower = text.to_ascii_lowercase();
    let mut new = String::with_capacity(text.len());
    let mut from = 0;
    for (at, word) in lower.match_indices("xplb_abqerr") {
        let open = at + word.len() + lower[at + word.len()..].len() - lower[at + word.len()..].trim_start().len();
        if at < from || !lower[open..].starts_with('(') {
            continue;
        }
        let Some(filled) = filled(&text[open + 1..]) else { continue };
        new += &text[from..=open];
        new += &filled.0;
        from = open + 1 + filled.1;
    }
    if from == 0 {
        return text;
    }
    new + &text[from..]
}

/// Returns the complete arguments up to the closing bracket, and the length of the original ones.
fn filled(text: &str) -> Option<(String, usize)> {
    let mut new = String::new();
    let (mut depth, mut quote, mut count, mut empty, mut column) = (0, None, 0, true, 0);
    for (at, c) in text.char_indices() {
        let continues = column == 5 && quote.is_none() && text[..at].ends_with("     ");
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (Some(_), '\n') => return None,
            (Some(_), _) => {}
            (None, '\'' | '"') => (quote, empty) = (Some(c), false),
            (None, '(') => (depth, empty) = (depth + 1, false),
            (None, ')') if depth > 0 => depth -= 1,
            (None, ',' | ')') if depth == 0 => {
                if empty {
                    new += FILLERS.get(count)?;
                }
                count += 1;
                if c == ')' {
                    for filler in FILLERS.iter().skip(count) {
                        new.push(',');
                        new += filler;
                    }
                    return Some((new, at));
                }
                empty = true;
            }
            (None, '&') => {}
            (None, c) if !c.is_whitespace() && !continues => empty = false,
            _ => {}
        }
        new.push(c);
        column = if c == '\n' { 0 } else { column + 1 };
    }
    None
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{IncludePlace, fill_arguments, include_line, included, logical, ready};

    #[test]
    fn includes_are_found_in_both_styles() {
        assert_eq!(included("      include 'vaba_param.inc'"), Some("vaba_param.inc"));
        assert_eq!(included("#include \"law.h\""), Some("law.h"));
        assert_eq!(included("      INCLUDE \"Law.Inc\" ! x"), Some("Law.Inc"));
        assert_eq!(included("      includes = 1"), None);
    }

    #[test]
    fn includes_get_the_case_and_path_of_existing_files() {
        let known = ["vaba_param.inc".to_owned(), "vaba_param_dp.inc".to_owned()];
        let nowhere = Path::new("/nowhere");
        let line = |text: &str| include_line(text, IncludePlace { main: nowhere, here: nowhere, known: &known });
        assert_eq!(line("      INCLUDE '../vaba_param_dp.INC'"), "      INCLUDE 'vaba_param_dp.inc'");
        assert_eq!(line("#include 'Vaba_Param.inc'"), "#include \"vaba_param.inc\"");
        assert_eq!(line("      include 'vaba_param.inc'"), "      include 'vaba_param.inc'");
        assert_eq!(line("      x = 1"), "      x = 1");
    }

    #[test]
    fn logicals_are_compared_with_eqv() {
        let line = |text: &str| logical(text.to_owned());
        assert_eq!(line("      DO WHILE(done == .FALSE.)"), "      DO WHILE(done .eqv. .FALSE.)");
        assert_eq!(line("if (a.eq..true. .and. b /= .true.) x"), "if (a.eqv..true. .and. b .neqv. .true.) x");
        assert_eq!(line("if (.true. .ne. a) x = i == 1"), "if (.true. .neqv. a) x = i == 1");
        for same in ["c  a == .true.", "write(*,*) 'a == .true.'", "a = .true. ! b == .true.", "l = i == 1 .or. .true."]
        {
            assert_eq!(line(same), same);
        }
    }

    #[test]
    fn omitted_arguments_are_filled() {
        let filled = |text: &str| fill_arguments(text.to_owned());
        assert_eq!(
            filled("      call xplb_abqerr(-3,'a (b), c',,,)\n"),
            "      call xplb_abqerr(-3,'a (b), c',0,0.d0,' ')\n"
        );
        assert_eq!(
            filled("      call XPLB_ABQERR(1,'a',\n     *  , r(1),)"),
            "      call XPLB_ABQERR(1,'a',\n     *  0, r(1),' ')"
        );
        assert_eq!(filled("call xplb_abqerr(-2, 'a')"), "call xplb_abqerr(-2, 'a',0,0.d0,' ')");
        let whole = "      call xplb_abqerr(1,'%I',i,r,c)\n";
        assert_eq!(filled(whole), whole);
    }

    #[test]
    fn header_is_moved_into_each_subroutine() {
        let text =
            "#include <SMAAspUserSubroutines.hdr>\n      subroutine a\n      include 'vaba_param.inc'\n      end\n";
        let known = ["vaba_param.inc".to_owned(), "SMAAspUserSubroutines.hdr".to_owned()];
        let nowhere = Path::new("/nowhere");
        let new = ready(text, Path::new("a.f"), IncludePlace { main: nowhere, here: nowhere, known: &known });
        let lines: Vec<&str> = new.lines().collect();
        assert_eq!(lines[0], "");
        assert_eq!(lines[3..5], ["#include \"SMAAspUserSubroutines.hdr\"", "# 4 \"a.f\""]);
    }
}
