//! Dakota parameters files and results files (Dakota User's Manual, "Parameters file format", "Results file format",
//! "Batch evaluation"): standard, APREPRO and JSON format, one evaluation or a batch.

use std::path::Path;

use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};

use super::StudyError;
use super::grid::CaseGrid;
use super::quantity::Quantity;
use super::sweep::SweepResults;

#[derive(Clone, Debug, PartialEq)]
pub struct DakotaRequest {
    form: FileFormat,
    evaluations: Vec<DakotaEvaluation>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FileFormat {
    /// One pair of value and tag per line (standard or APREPRO).
    Text,
    Json,
    JsonBatch,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct DakotaEvaluation {
    variables: Vec<DakotaVariable>,
    responses: Vec<DakotaResponse>,
    /// Number of the evaluation, in a batch preceded by that of the batch.
    #[serde(rename = "eval_id")]
    id: String,
    /// Labels of requested metadata.
    #[serde(default)]
    metadata: Vec<String>,
    /// Numbers of the variables, from 1, by which requested gradients are derivatives.
    #[serde(default)]
    derivative_variables: Vec<usize>,
}

/// Derivatives of each response of an evaluation by its derivative variables; `None` if one is unknown.
pub type DakotaGradients = Option<Vec<Vec<f64>>>;

/// Bits of the active set of a response.
const VALUE: u64 = 1;
const GRADIENT: u64 = 2;
const HESSIAN: u64 = 4;

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct DakotaVariable {
    label: String,
    #[serde(deserialize_with = "number_or_text")]
    value: String,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct DakotaResponse {
    label: String,
    /// Requested data as a bit mask: 1 value, 2 gradient, 4 second derivatives.
    active_set: u64,
}

impl DakotaRequest {
    pub fn read(path: &Path, text: &str, quantities: &[Quantity]) -> Result<DakotaRequest, StudyError> {
        let wrong = |message: String| StudyError::file("--dakota", path, message);
        let request = match text.trim_start().chars().next() {
            Some('[') => from_json(text, true),
            // A line in APREPRO format begins with a brace as well, but is not valid JSON.
            Some('{') if serde_json::from_str::<Value>(text).is_ok() => from_json(text, false),
            Some(_) => from_lines(text),
            None => Err("the file is empty".into()),
        };
        let request = request.map_err(wrong)?;
        request.answerable(quantities).map_err(wrong)?;
        Ok(request)
    }

    /// Checks that a sweep can evaluate all requested responses.
    fn answerable(&self, quantities: &[Quantity]) -> Result<(), String> {
        let [first, rest @ ..] = &self.evaluations[..] else { return Err("the file has no evaluation".into()) };
        let names = |e: &DakotaEvaluation| e.variables.iter().map(|v| v.label.clone()).collect::<Vec<_>>();
        if let Some(other) = rest.iter().find(|e| names(e) != names(first)) {
            return Err(format!("the variables of evaluation {} differ from those of the first evaluation", other.id));
        }
        for evaluation in &self.evaluations {
            let DakotaEvaluation { responses, id, metadata, variables, derivative_variables } = evaluation;
            if let Some(number) = derivative_variables.iter().find(|number| !(1..=variables.len()).contains(*number)) {
                return Err(format!(
                    "evaluation {id} requests derivatives by variable {number}, which it does not have"
                ));
            }
            if responses.len() != quantities.len() {
                let (requested, quantity_count) = (responses.len(), quantities.len());
                return Err(format!(
                    "evaluation {id} requests {requested} responses, but --quantity is given {quantity_count} times"
                ));
            }
            if let Some(DakotaResponse { label, .. }) = responses.iter().find(|r| r.active_set & HESSIAN != 0) {
                return Err(format!(
                    "evaluation {id} requests second derivatives of {label}: use no_hessians, or a method that estimates them"
                ));
            }
            if let Some(label) = metadata.first() {
                return Err(format!("evaluation {id} requests metadata ({label}), which are unsupported"));
            }
        }
        Ok(())
    }

    /// Returns the evaluations as cases of a sweep; `settings` give one value to each other parameter.
    pub fn grid(&self, settings: &[String]) -> Result<CaseGrid, StudyError> {
        let names = self.evaluations[0].variables.iter().map(|v| v.label.clone()).collect();
        let row = |e: &DakotaEvaluation| e.variables.iter().map(|v| v.value.clone()).collect();
        CaseGrid::of_rows(names, self.evaluations.iter().map(row).collect()).with_fixed_parameters(settings, "--dakota")
    }

    /// Returns the names of the variables by which each evaluation requests gradients; `None` without a request.
    pub fn gradient_names(&self) -> Vec<Option<Vec<String>>> {
        let names = |evaluation: &DakotaEvaluation| {
            let is_requested = evaluation.responses.iter().any(|response| response.active_set & GRADIENT != 0);
            let label = |number: &usize| evaluation.variables[number - 1].label.clone();
            is_requested.then(|| evaluation.derivative_variables.iter().map(label).collect())
        };
        self.evaluations.iter().map(names).collect()
    }

    /// Formats a results file in which all evaluations have failed.
    pub fn failed(&self) -> String {
        let values = self.evaluations.iter().map(|_| Err(StudyError::Reported(String::new()))).collect();
        self.answer(&SweepResults { values, ..SweepResults::default() }, &vec![None; self.evaluations.len()])
    }

    /// Formats the results file: values and gradients in the requested order with all digits, FAIL for evaluations without
    /// them.
    pub fn answer(&self, results: &SweepResults, gradients: &[DakotaGradients]) -> String {
        let answered = self.evaluations.iter().zip(&results.values).zip(gradients);
        let answers =
            answered.map(|((request, values), gradients)| request.answer(values.as_deref().ok(), gradients.as_deref()));
        if self.form != FileFormat::Text {
            let objects: Vec<Value> =
                answers.map(|answer| answer.map_or(json!({ "fail": true }), |a| a.object())).collect();
            let value = if self.form == FileFormat::Json {
                objects.into_iter().next().unwrap_or_default()
            } else {
                objects.into()
            };
            return format!("{value:#}\n");
        }
        // In a batch each evaluation begins with a line `#`.
        let batch = self.evaluations[0].id.contains(':');
        let blocks = answers.map(|answer| {
            let begin = if batch { "#\n" } else { "" };
            format!("{begin}{}", answer.map_or("FAIL\n".into(), |answer| answer.lines()))
        });
        blocks.collect()
    }
}

/// Requested values and gradients of an evaluation, with their labels.
struct DakotaAnswer<'a> {
    values: Vec<(&'a str, f64)>,
    gradients: Vec<(&'a str, &'a [f64])>,
}

impl DakotaEvaluation {
    /// Returns the requested data; `None` if a number is missing or not finite.
    fn answer<'a>(&'a self, values: Option<&[f64]>, gradients: Option<&'a [Vec<f64>]>) -> Option<DakotaAnswer<'a>> {
        let requested = |bit: u64| {
            let responses = self.responses.iter().enumerate();
            responses.filter(move |(_, response)| response.active_set & bit != 0)
        };
        let value = |(index, response): (usize, &'a DakotaResponse)| {
            let value = values?.get(index).filter(|value| value.is_finite())?;
            Some((response.label.as_str(), *value))
        };
        let gradient = |(index, response): (usize, &'a DakotaResponse)| {
            let gradient = gradients?.get(index).filter(|gradient| gradient.iter().all(|slope| slope.is_finite()))?;
            Some((response.label.as_str(), &gradient[..]))
        };
        let values = requested(VALUE).map(value).collect::<Option<_>>()?;
        Some(DakotaAnswer { values, gradients: requested(GRADIENT).map(gradient).collect::<Option<_>>()? })
    }
}

impl DakotaAnswer<'_> {
    fn lines(&self) -> String {
        let number = |slope: &f64| format!("{slope:24.16e}");
        let values = self.values.iter().map(|(label, value)| format!("{value:24.16e} {label}\n"));
        let gradients = self
            .gradients
            .iter()
            .map(|(_, gradient)| format!("[ {} ]\n", gradient.iter().map(number).collect::<Vec<_>>().join(" ")));
        values.chain(gradients).collect()
    }

    fn object(&self) -> Value {
        let values: Map<String, Value> =
            self.values.iter().map(|(label, value)| ((*label).to_owned(), (*value).into())).collect();
        let gradients: Map<String, Value> =
            self.gradients.iter().map(|(label, gradient)| ((*label).to_owned(), gradient.to_vec().into())).collect();
        if gradients.is_empty() {
            json!({ "functions": values })
        } else {
            json!({ "functions": values, "gradients": gradients })
        }
    }
}

fn from_json(text: &str, batch: bool) -> Result<DakotaRequest, String> {
    let read = if batch { serde_json::from_str(text) } else { serde_json::from_str(text).map(|one| vec![one]) };
    let form = if batch { FileFormat::JsonBatch } else { FileFormat::Json };
    Ok(DakotaRequest { form, evaluations: read.map_err(|e| e.to_string())? })
}

/// Deserialises a number or a string as the text of a deck parameter.
fn number_or_text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let value = Value::deserialize(deserializer)?;
    Ok(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
}

/// Value and tag of a line, with the line number.
struct TaggedValue {
    at: usize,
    value: String,
    tag: String,
}

/// Parses a line: `value tag` or `{ tag = value }`.
fn pair(at: usize, line: &str) -> Result<TaggedValue, String> {
    let line = line.trim();
    let wrong = || format!("line {at}: `{line}` is not a value with a tag");
    let (tag, value) = match line.strip_prefix('{').and_then(|inner| inner.strip_suffix('}')) {
        Some(inner) => inner.split_once('=').ok_or_else(wrong)?,
        None => line.rsplit_once(char::is_whitespace).map(|(value, tag)| (tag, value)).ok_or_else(wrong)?,
    };
    let value = value.trim().trim_matches('"').to_owned();
    Ok(TaggedValue { at, value, tag: tag.trim().to_owned() })
}

/// Sequential reader of pairs.
struct PairReader<'a> {
    rest: &'a [TaggedValue],
}

impl<'a> PairReader<'a> {
    /// Returns the next pair, which must have one of two tags.
    fn expect(&mut self, tags: [&str; 2]) -> Result<&'a TaggedValue, String> {
        let [next, rest @ ..] = self.rest else { return Err(format!("the file ends before `{}`", tags[0])) };
        if !tags.contains(&next.tag.as_str()) {
            return Err(format!("line {}: found `{}`, expected `{}`", next.at, next.tag, tags[0]));
        }
        self.rest = rest;
        Ok(next)
    }

    /// Returns a block of pairs; a preceding pair with one of two tags gives their number.
    fn block(&mut self, tags: [&str; 2]) -> Result<&'a [TaggedValue], String> {
        let head = self.expect(tags)?;
        let count: usize =
            head.value.parse().map_err(|_| format!("line {}: `{}` is not a number", head.at, head.value))?;
        if count > self.rest.len() {
            return Err(format!("line {}: the file ends before {count} {}", head.at, head.tag));
        }
        let (block, following) = self.rest.split_at(count);
        self.rest = following;
        Ok(block)
    }
}

fn from_lines(text: &str) -> Result<DakotaRequest, String> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let pairs: Vec<TaggedValue> = lines.map(|(i, line)| pair(i + 1, line)).collect::<Result<_, _>>()?;
    let mut pairs = PairReader { rest: &pairs };
    let mut evaluations = Vec::new();
    while !pairs.rest.is_empty() {
        evaluations.push(evaluation(&mut pairs)?);
    }
    Ok(DakotaRequest { form: FileFormat::Text, evaluations })
}

fn evaluation(pairs: &mut PairReader<'_>) -> Result<DakotaEvaluation, String> {
    let variables = pairs.block(["variables", "DAKOTA_VARS"])?;
    let mut responses = Vec::new();
    for pair in pairs.block(["functions", "DAKOTA_FNS"])? {
        let active_set =
            pair.value.parse().map_err(|_| format!("line {}: `{}` is not a number", pair.at, pair.value))?;
        // ASV_1:label; older versions write no label.
        let label = pair.tag.split_once(':').map_or(&*pair.tag, |tag| tag.1);
        responses.push(DakotaResponse { label: label.to_owned(), active_set });
    }
    let mut derivative_variables = Vec::new();
    for pair in pairs.block(["derivative_variables", "DAKOTA_DER_VARS"])? {
        let number = pair.value.parse().map_err(|_| format!("line {}: `{}` is not a number", pair.at, pair.value))?;
        derivative_variables.push(number);
    }
    pairs.block(["analysis_components", "DAKOTA_AN_COMPS"])?;
    // Versions before 6.16 write no metadata, the oldest no evaluation number either.
    let begins =
        |tags: [&str; 2], pairs: &PairReader<'_>| pairs.rest.first().is_some_and(|p| tags.contains(&p.tag.as_str()));
    let (id_tags, more) = (["eval_id", "DAKOTA_EVAL_ID"], ["metadata", "DAKOTA_METADATA"]);
    let id = if begins(id_tags, pairs) { pairs.expect(id_tags)?.value.clone() } else { String::new() };
    let metadata = if begins(more, pairs) { pairs.block(more)? } else { &[] };
    Ok(DakotaEvaluation {
        variables: variables.iter().map(|p| DakotaVariable { label: p.tag.clone(), value: p.value.clone() }).collect(),
        responses,
        id,
        metadata: metadata.iter().map(|p| p.value.clone()).collect(),
        derivative_variables,
    })
}

#[cfg(test)]
mod tests {
    use super::{DakotaRequest, FileFormat};
    use crate::study::StudyError;
    use crate::study::quantity::Quantity;
    use crate::study::sweep::SweepResults;

    fn standard(id: &str, request: u8, value: f64) -> String {
        format!(
            "                     2 variables\n{value:.15e} V\n  0.1 mu\n   1 functions\n {request} ASV_1:depth\n   1 derivative_variables\n   \
             1 DVV_1:V\n   1 analysis_components\n  a b AC_1:first.sh\n   {id} eval_id\n   0 metadata\n"
        )
    }

    fn read(text: &str, quantities: usize) -> Result<DakotaRequest, StudyError> {
        let quantities: Vec<Quantity> =
            (0..quantities).map(|_| Quantity::parse("final(U2@REF)").expect("a quantity")).collect();
        DakotaRequest::read("params.in".as_ref(), text, &quantities)
    }

    fn values(request: &DakotaRequest) -> Vec<String> {
        let grid = request.grid(&["n=20".into()]).expect("a grid");
        assert_eq!(grid.names(), ["V", "mu", "n"]);
        let row = |i: usize| grid.combination(i).into_iter().map(|p| p.1).collect::<Vec<_>>().join(" ");
        (0..grid.count()).map(row).collect()
    }

    fn answer(request: &DakotaRequest) -> String {
        let values = vec![Ok(vec![0.1]), Err(StudyError::Reported("halted".into()))];
        request.answer(&SweepResults { values, ..SweepResults::default() }, &[None, None])
    }

    #[test]
    fn one_evaluation_in_three_formats() {
        let text = standard("7", 1, 821.0);
        let request = read(&text, 1).expect("standard");
        assert_eq!(values(&request), ["8.210000000000000e2 0.1 20"]);
        assert_eq!(answer(&request), "   1.0000000000000001e-1 depth\n");
        let aprepro = "{ DAKOTA_VARS     =                      2 }\n{ V = 821 }\n{ mu = 0.1 }\n{ DAKOTA_FNS = 1 }\n\
                       { ASV_1:depth = 1 }\n{ DAKOTA_DER_VARS = 0 }\n{ DAKOTA_AN_COMPS = 0 }\n{ DAKOTA_EVAL_ID = 1 }\n";
        assert_eq!(values(&read(aprepro, 1).expect("APREPRO")), ["821 0.1 20"]);
        let object = r#"{"variables": [{"label": "V", "value": 821.5}, {"label": "mu", "value": "0.1"}], "eval_id": "1",
            "responses": [{"label": "depth", "active_set": 1}], "derivative_variables": [1], "analysis_components": []}"#;
        let request = read(object, 1).expect("JSON");
        assert_eq!((request.form, values(&request)), (FileFormat::Json, vec!["821.5 0.1 20".to_owned()]));
        let answered: serde_json::Value = serde_json::from_str(&answer(&request)).expect("JSON");
        assert_eq!(answered["functions"]["depth"], 0.1);
        let batch = read(&format!("[{object}, {object}]"), 1).expect("JSON");
        let answered: serde_json::Value = serde_json::from_str(&answer(&batch)).expect("JSON");
        assert_eq!((&answered[0]["functions"]["depth"], &answered[1]["fail"]), (&0.1.into(), &true.into()));
    }

    #[test]
    fn batch_results_have_the_order_of_the_request() {
        let request = read(&(standard("1:1", 1, 500.0) + &standard("1:2", 1, 600.0)), 1).expect("a batch");
        assert_eq!(values(&request).len(), 2);
        assert_eq!(answer(&request), "#\n   1.0000000000000001e-1 depth\n#\nFAIL\n");
    }

    /// Source: Dakota Reference Manual, "results_file": values, then gradients in brackets, in the order of the responses.
    #[test]
    fn gradients_follow_values() {
        let text = standard("7", 3, 821.0)
            .replace("1 derivative_variables\n   1 DVV_1:V", "2 derivative_variables\n 1 DVV_1:V\n 2 DVV_2:mu");
        let request = read(&text, 1).expect("standard");
        assert_eq!(request.gradient_names(), [Some(vec!["V".to_owned(), "mu".to_owned()])]);
        let results = SweepResults { values: vec![Ok(vec![0.1])], ..SweepResults::default() };
        let answered = request.answer(&results, &[Some(vec![vec![0.5, -2.0]])]);
        let words: Vec<&str> = answered.split_whitespace().collect();
        assert_eq!(
            words,
            ["1.0000000000000001e-1", "depth", "[", "5.0000000000000000e-1", "-2.0000000000000000e0", "]"]
        );
        assert_eq!(request.answer(&results, &[None]), "FAIL\n");
        assert_eq!(read(&standard("7", 1, 821.0), 1).expect("standard").gradient_names(), [None]);
    }

    #[test]
    fn unsupported_requests_are_errors() {
        let refused = |text: &str, quantities: usize, word: &str| {
            let message = read(text, quantities).expect_err(text).to_string();
            assert!(message.contains(word), "{message}");
        };
        let text = standard("7", 1, 821.0);
        refused(&text, 2, "2 times");
        refused(&standard("7", 5, 821.0), 1, "second derivatives");
        refused(&standard("7", 3, 821.0).replace("1 DVV_1:V", "3 DVV_3:V"), 1, "by variable 3");
        refused(&text.replace("0 metadata", "1 metadata\n seconds MD_1"), 1, "metadata");
        refused("", 1, "empty");
        refused("[]", 1, "no evaluation");
        refused("{\"variables\": 1}", 1, "expected");
        refused(&text.replace("functions", "fonctions"), 1, "line 4");
        refused(&text.replace("2 variables", "20 variables"), 1, "ends before");
        // A truncated file must not cause a panic.
        for end in 0..text.len() {
            let _ = read(&text[..end], 1);
        }
    }
}
