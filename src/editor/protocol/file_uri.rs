//! Conversion of `file:` URIs to paths and back.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Returns the path of a `file:` URI; `None` for other schemes. The drive letter of Windows has no slash before it.
pub fn path_of_uri(uri: &str) -> Option<PathBuf> {
    let location = uri.strip_prefix("file://")?;
    let path_start = location.find('/')?;
    let (host, path) = location.split_at(path_start);
    let path = String::from_utf8(decoded(path)).ok()?;
    let drive = path.as_bytes().get(1).is_some_and(u8::is_ascii_alphabetic) && path.as_bytes().get(2) == Some(&b':');
    Some(match host {
        "" | "localhost" if drive => PathBuf::from(&path[1..]),
        "" | "localhost" => PathBuf::from(path),
        host => PathBuf::from(format!("//{host}{path}")),
    })
}

fn decoded(path: &str) -> Vec<u8> {
    let bytes = path.as_bytes();
    let (mut out, mut i) = (Vec::with_capacity(bytes.len()), 0);
    while i < bytes.len() {
        let hex = bytes.get(i + 1..i + 3).and_then(|two| std::str::from_utf8(two).ok());
        match hex.and_then(|two| u8::from_str_radix(two, 16).ok()).filter(|_| bytes[i] == b'%') {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    out
}

/// Returns the `file:` URI of an absolute path.
pub fn uri_of_path(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let text = text.strip_prefix("//?/").unwrap_or(&text);
    let mut uri = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' | b':' => {
                uri.push(char::from(byte))
            }
            _ => drop(write!(uri, "%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_the_way_to_a_uri_and_back() {
        for path in ["/a/b c.inp", "/d\u{e4}/50%.inp", "C:/x/y.inp"] {
            assert_eq!(path_of_uri(&uri_of_path(Path::new(path))), Some(PathBuf::from(path)));
        }
        assert_eq!(path_of_uri("file:///c%3A/a.inp"), Some(PathBuf::from("c:/a.inp")));
        assert_eq!(path_of_uri("untitled:Untitled-1"), None);
    }
}
