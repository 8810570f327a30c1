//! The HTML page around the data: one self-contained file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::ReportError;
use super::data::ReportPage;
use crate::output::vtu::escape;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Returns the content security policy: the page loads nothing and uses only its own style and script. The script is
/// permitted by the SHA-256 hash of its text, so that a browser runs no other.
fn policy(script: &str) -> String {
    let hash = STANDARD.encode(hmac_sha256::Hash::hash(script.as_bytes()));
    format!(
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{hash}'; img-src data:; base-uri 'none'; \
         form-action 'none'"
    )
}

pub fn html(page: &ReportPage) -> Result<String, ReportError> {
    let data = serde_json::to_string(page).map_err(|e| e.to_string())?;
    // Within a script element only `<` could end or change it.
    let data = data.replace('<', "\\u003c");
    let (title, script) = (escape(&page.title), format!("\n{SCRIPT}"));
    let policy = policy(&script);
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}: Revolve</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <main id=\"page\"><noscript>This page needs JavaScript, which is switched off.\
         </noscript></main>\n<script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>{script}</script>\n</body>\n</html>\n"
    ))
}
