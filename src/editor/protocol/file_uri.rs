//! Conversion of `file:` URIs to paths and back.

use std::path::{Path, PathBuf};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

/// Characters that are written by their number.
const ENCODED: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/').remove(b':');

/// Returns the path of a `file:` URI; `None` for other schemes. The drive letter of Windows has no slash before it.
pub fn path_of_uri(uri: &str) -> Option<PathBuf> {
    let location = uri.strip_prefix("file://")?;
    let path_start = location.find('/')?;
    let (host, path) = location.split_at(path_start);
    let path = percent_decode_str(path).decode_utf8().ok()?;
    let drive = path.as_bytes().get(1).is_some_and(u8::is_ascii_alphabetic) && path.as_bytes().get(2) == Some(&b':');
    Some(match host {
        "" | "localhost" if drive => PathBuf::from(&path[1..]),
        "" | "localhost" => PathBuf::from(path.into_owned()),
        host => PathBuf::from(format!("//{host}{path}")),
    })
}

/// Returns the `file:` URI of an absolute path.
pub fn uri_of_path(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let text = text.strip_prefix("//?/").unwrap_or(&text);
    let scheme = if text.starts_with('/') { "file://" } else { "file:///" };
    format!("{scheme}{}", utf8_percent_encode(text, ENCODED))
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
