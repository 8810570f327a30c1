//! The page around the data: one file that fetches nothing.

use super::ReportError;
use super::data::Page;
use crate::output::vtu::escape;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Nothing is loaded from anywhere; what runs and styles the page is in it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                      base-uri 'none'; form-action 'none'";

pub fn html(page: &Page) -> Result<String, ReportError> {
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
         <main id=\"page\"><noscript>This page draws itself with a script that is part of it; scripts are switched off.\
         </noscript></main>\n<script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}
