//! The HTML page around the data: one self-contained file.

use super::ReportError;
use super::data::ReportPage;
use crate::output::vtu::escape;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Content security policy: the page loads nothing and uses only its own script and style.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                      base-uri 'none'; form-action 'none'";

pub fn html(page: &ReportPage) -> Result<String, ReportError> {
    let data = serde_json::to_string(page).map_err(|e| e.to_string())?;
    // Within a script element only `<` could end or change it.
    let data = data.replace('<', "\\u003c");
    let title = escape(&page.title);
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}: Revolve</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <main id=\"page\"><noscript>This page needs JavaScript, which is switched off.\
         </noscript></main>\n<script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}
