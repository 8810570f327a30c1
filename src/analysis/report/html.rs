//! HTML pages around data and a script: self-contained files, and the pages of a view.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest as _, Sha256};

use super::ReportError;
use super::data::ReportPage;
use crate::output::vtu::escape;

/// Style of all pages.
pub(crate) const STYLE: &str = include_str!("page.css");
/// Functions that draw charts, meridian sections and tables, used by the scripts of all pages.
pub(crate) const SHARED_SCRIPT: &str = include_str!("shared.js");
const SCRIPT: &str = include_str!("page.js");

/// Contents of a page that differ between pages.
pub(crate) struct PageContents<'a> {
    pub title: &'a str,
    pub style: &'a str,
    pub script: &'a str,
    /// JSON text that the script reads.
    pub data: &'a str,
    /// Further directives of the content security policy, each ended by `; `.
    pub permissions: &'a str,
}

impl PageContents<'_> {
    /// Returns the content security policy: the page loads nothing but what `permissions` allow, and uses only its own
    /// style and script. The script is permitted by the SHA-256 hash of its text, so that a browser runs no other.
    fn policy(&self, script: &str) -> String {
        let hash = STANDARD.encode(Sha256::digest(script.as_bytes()));
        format!(
            "default-src 'none'; {}style-src 'unsafe-inline'; script-src 'sha256-{hash}'; img-src data:; base-uri 'none'; \
             form-action 'none'",
            self.permissions
        )
    }

    /// Returns the text of the page.
    pub fn html(&self) -> String {
        // Within a script element only `<` could end or change it.
        let data = self.data.replace('<', "\\u003c");
        let (title, script) = (escape(self.title), format!("\n{}", self.script));
        let (policy, style) = (self.policy(&script), self.style);
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>{title}: Revolve</title>\n<style>\n{style}</style>\n</head>\n<body>\n\
             <main id=\"page\"><noscript>This page needs JavaScript, which is switched off.\
             </noscript></main>\n<script type=\"application/json\" id=\"data\">{data}</script>\n\
             <script>{script}</script>\n</body>\n</html>\n"
        )
    }
}

pub fn html(page: &ReportPage) -> Result<String, ReportError> {
    let data = serde_json::to_string(page).map_err(|e| e.to_string())?;
    let script = [SHARED_SCRIPT, SCRIPT].concat();
    let (title, style) = (page.title.as_str(), STYLE);
    Ok(PageContents { title, style, script: &script, data: &data, permissions: "" }.html())
}
