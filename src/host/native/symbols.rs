//! Symbols of a shared library, read from its file: variables, imported functions, needed libraries. ("Tool Interface
//! Standard: Executable and Linking Format", version 1.2; 64 bits.)

/// A variable in the memory of a library.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LibraryVariable {
    /// Offset from the base of the library, or from the start of the thread-local variables.
    pub at: usize,
    /// Size of the variable in bytes.
    pub size: usize,
    /// Whether each thread has its own copy.
    pub of_thread: bool,
    /// Name of the symbol, as the linker uses it.
    pub symbol: String,
}

/// Variables, imported symbols and dependencies of a library.
#[derive(Clone, Debug, Default)]
pub struct LibrarySymbols {
    /// Variables in ascending order of their offset.
    pub variables: Vec<LibraryVariable>,
    /// Imported functions and variables.
    pub imported: Vec<String>,
    /// Names of the libraries that this one depends on.
    pub needed: Vec<String>,
}

const SYMBOLS: u32 = 2;
const DYNAMIC: u32 = 6;
const DYNAMIC_SYMBOLS: u32 = 11;

/// A section: type, offset, size, and index of the section it refers to.
#[derive(Clone, Copy)]
struct FileSection {
    kind: u32,
    offset: usize,
    size: usize,
    link: usize,
}

impl LibrarySymbols {
    /// Reads a file; the result is empty if the file is not a complete 64-bit ELF file.
    pub fn read(file: &[u8]) -> LibrarySymbols {
        let mut symbols = LibrarySymbols::default();
        let sections = sections(file).unwrap_or_default();
        for section in &sections {
            let Some(table) = part(file, section) else { continue };
            let names = sections.get(section.link).and_then(|s| part(file, s)).unwrap_or_default();
            match section.kind {
                SYMBOLS | DYNAMIC_SYMBOLS => table.chunks_exact(24).for_each(|entry| symbols.add(entry, names)),
                DYNAMIC => symbols.needed.extend(table.chunks_exact(16).filter_map(|entry| needed(entry, names))),
                _ => {}
            }
        }
        symbols.variables.sort();
        symbols.variables.dedup();
        symbols
    }

    fn add(&mut self, entry: &[u8], names: &[u8]) {
        const UNDEFINED: u16 = 0;
        const OBJECT: u8 = 1;
        const OF_THREAD: u8 = 6;
        let (Some(name), Some(at), Some(size)) = (number(entry, 0, 4), number(entry, 8, 8), number(entry, 16, 8))
        else {
            return;
        };
        let (kind, section) = (entry[4] & 0xf, u16::from_le_bytes([entry[6], entry[7]]));
        let symbol = text(names, name);
        if section == UNDEFINED {
            self.imported.push(symbol);
        } else if matches!(kind, OBJECT | OF_THREAD) && size > 0 {
            self.variables.push(LibraryVariable { at, size, of_thread: kind == OF_THREAD, symbol });
        }
    }

    /// Returns the variable that contains a byte, and the offset of the byte in it.
    pub fn variable(&self, at: usize, of_thread: bool) -> Option<(&LibraryVariable, usize)> {
        let holds = |v: &&LibraryVariable| v.of_thread == of_thread && (v.at..v.at + v.size).contains(&at);
        self.variables.iter().find(holds).map(|v| (v, at - v.at))
    }
}

impl LibraryVariable {
    /// Returns whether this is a COMMON block or a variable of a module, which subroutines share by its name.
    pub fn is_shared_data(&self) -> bool {
        let symbol = self.symbol.as_str();
        let is_common = symbol.ends_with('_') && symbol.starts_with(|c: char| c.is_ascii_alphabetic());
        is_common || symbol == "__BLNK__" || symbol.starts_with("__") && symbol.contains("_MOD_")
    }

    /// Returns the name in the source: gfortran writes `x.12` for a local variable with SAVE, `__m_MOD_x` for one of a
    /// module, an underscore after the name of a COMMON block, `__BLNK__` for blank COMMON.
    pub fn plain_name(&self) -> String {
        let symbol = self.symbol.as_str();
        if let Some((module, name)) = symbol.strip_prefix("__").and_then(|s| s.split_once("_MOD_")) {
            return format!("`{name}` of module `{module}`");
        }
        if symbol == "__BLNK__" {
            return "blank COMMON".into();
        }
        if let Some((name, number)) = symbol.rsplit_once('.')
            && number.bytes().all(|b| b.is_ascii_digit())
        {
            return format!("`{name}`");
        }
        match symbol.strip_suffix('_') {
            Some(block) => format!("COMMON /{block}/"),
            None => format!("`{symbol}`"),
        }
    }
}

fn sections(file: &[u8]) -> Option<Vec<FileSection>> {
    let is_known = file.get(..6)? == b"\x7fELF\x02\x01";
    let (offset, count) = (number(file, 0x28, 8)?, number(file, 0x3c, 2)?);
    let table = file.get(offset..offset.checked_add(64 * count)?).filter(|_| is_known)?;
    let section = |entry: &[u8]| {
        let [kind, link] = [4, 40].map(|at| number(entry, at, 4));
        Some(FileSection {
            kind: kind? as u32,
            link: link?,
            offset: number(entry, 24, 8)?,
            size: number(entry, 32, 8)?,
        })
    };
    table.chunks_exact(64).map(section).collect()
}

fn part<'a>(file: &'a [u8], section: &FileSection) -> Option<&'a [u8]> {
    file.get(section.offset..section.offset.checked_add(section.size)?)
}

/// Reads a little-endian number of `count` bytes.
fn number(bytes: &[u8], at: usize, count: usize) -> Option<usize> {
    let mut wide = [0; 8];
    wide[..count].copy_from_slice(bytes.get(at..at.checked_add(count)?)?);
    usize::try_from(u64::from_le_bytes(wide)).ok()
}

fn text(names: &[u8], at: usize) -> String {
    let tail = names.get(at..).unwrap_or_default();
    let end = tail.iter().position(|b| *b == 0).unwrap_or(tail.len());
    String::from_utf8_lossy(&tail[..end]).into_owned()
}

/// Returns the needed library of an entry of the dynamic section.
fn needed(entry: &[u8], names: &[u8]) -> Option<String> {
    const NEEDED: usize = 1;
    (number(entry, 0, 8)? == NEEDED).then(|| text(names, number(entry, 8, 8).unwrap_or(usize::MAX)))
}

#[cfg(test)]
mod tests {
    use super::{LibrarySymbols, LibraryVariable};

    #[test]
    fn symbols_convert_to_source_names() {
        let name =
            |symbol: &str| LibraryVariable { at: 0, size: 8, of_thread: false, symbol: symbol.into() }.plain_name();
        assert_eq!(name("calls.17"), "`calls`");
        assert_eq!(name("__law_MOD_table"), "`table` of module `law`");
        assert_eq!(name("state_"), "COMMON /state/");
        assert_eq!(name("__BLNK__"), "blank COMMON");
        assert_eq!(name("counter"), "`counter`");
    }

    /// The running executable is an ELF file; truncated copies are read without a panic.
    #[test]
    fn complete_and_truncated_files_are_read() {
        let file = std::fs::read("/proc/self/exe").expect("this program");
        let symbols = LibrarySymbols::read(&file);
        assert!(symbols.needed.iter().any(|name| name.starts_with("libc.")), "{:?}", symbols.needed);
        assert!(symbols.imported.iter().any(|name| name == "dl_iterate_phdr") && symbols.variables.len() > 10);
        for length in [0, 5, 63, 64, file.len() / 2, file.len() - 1] {
            assert!(LibrarySymbols::read(&file[..length]).variables.len() <= symbols.variables.len());
        }
        assert!(LibrarySymbols::read(b"#!/bin/sh\n").needed.is_empty());
    }
}
