//! What a compiled routine may ask of the program that calls it: the job's name and folder, numbers of nodes and elements
//! in their parts, sensors, and a place for messages. All of one thread, as a run is.
//! Never here: pointers.

use std::cell::RefCell;

use serde::Serialize;

use crate::state::archive::{Archive, Persist, persist_fields};

/// How grave a message is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// `LOP = 1`.
    #[default]
    Note,
    /// `LOP = -1`.
    Warning,
    /// `LOP = -2` or `-3`.
    Error,
}

/// A message of a routine (`xplb_abqerr`).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Message {
    /// How grave.
    pub level: Level,
    /// In the routine's words.
    pub text: String,
    /// How often it was given.
    pub times: u64,
}

/// What a routine can learn of its job.
#[derive(Clone, Debug, Default)]
pub struct JobInfo {
    /// Name of the job (`vgetjobname`).
    pub name: String,
    /// Folder of the results, absolute (`vgetoutdir`).
    pub folder: String,
    /// Names of the nodes, `12` or `INSTANCE.12`; a node's number inside the program is its place here, from 1.
    pub nodes: Vec<String>,
    /// Names of the elements.
    pub elements: Vec<String>,
}

/// Different messages that are kept; a routine may give one every increment.
const MOST: usize = 200;

thread_local! {
    static JOB: RefCell<JobInfo> = RefCell::default();
    static MESSAGES: RefCell<Vec<Message>> = const { RefCell::new(Vec::new()) };
}

/// Sets what routines called by this thread are told of their job, and forgets messages of the job before.
pub fn announce(job: JobInfo) {
    JOB.with_borrow_mut(|j| *j = job);
    MESSAGES.with_borrow_mut(Vec::clear);
}

/// The messages that routines gave since the job was announced.
pub fn take_messages() -> Vec<Message> {
    MESSAGES.take()
}

/// Visits the messages since the job was announced, which a run that goes on has given already.
pub fn persist_messages(archive: &mut Archive<'_>) {
    MESSAGES.with_borrow_mut(|list| list.persist(archive));
}

impl Persist for Message {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Message { level, text, times } = self;
        let mut number = *level as u8;
        persist_fields!(archive; &mut number, text, times);
        *level = [Level::Note, Level::Warning].into_iter().find(|l| *l as u8 == number).unwrap_or(Level::Error);
    }
}

pub(super) fn with_job<R>(ask: impl FnOnce(&JobInfo) -> R) -> R {
    JOB.with_borrow(ask)
}

pub(super) fn tell(level: Level, text: String) {
    MESSAGES.with_borrow_mut(|list| {
        if let Some(known) = list.iter_mut().find(|m| m.level == level && m.text == text) {
            known.times += 1;
        } else if list.len() < MOST {
            list.push(Message { level, text, times: 1 });
        }
    });
}

/// Number inside the program of what has this name in this instance; 0 if there is none.
pub(super) fn internal_number(names: &[String], part: &str, local: i32) -> i32 {
    let wanted = if part.is_empty() { local.to_string() } else { format!("{part}.{local}") };
    names.iter().position(|n| n.eq_ignore_ascii_case(&wanted)).map_or(0, |i| i as i32 + 1)
}

/// Instance and local number of what has this number inside the program.
pub(super) fn part_of(names: &[String], internal: i32) -> Option<(&str, i32)> {
    let name = names.get(usize::try_from(internal).ok()?.checked_sub(1)?)?;
    let (part, local) = name.rsplit_once('.').unwrap_or(("", name));
    Some((part, local.parse().ok()?))
}

/// Text of `xplb_abqerr` with its values in place of `%I`, `%R` and `%S`.
pub(super) fn fill_in(
    text: &str,
    mut integer: impl FnMut(usize) -> Option<i32>,
    mut real: impl FnMut(usize) -> Option<f64>,
    mut word: impl FnMut(usize) -> Option<String>,
) -> String {
    let mut filled = String::new();
    let (mut integers, mut reals, mut words) = (0, 0, 0);
    let mut rest = text.trim_end();
    while let Some(at) = rest.find('%') {
        filled += &rest[..at];
        let code = rest[at + 1..].chars().next();
        let value = match code {
            Some('I' | 'i') => count(&mut integers, &mut integer).map(|i| i.to_string()),
            Some('R' | 'r') => count(&mut reals, &mut real).map(|r| format!("{r:e}")),
            Some('S' | 's') => count(&mut words, &mut word),
            _ => None,
        };
        match value {
            Some(value) => {
                filled += &value;
                rest = &rest[at + 2..];
            }
            None => {
                filled.push('%');
                rest = &rest[at + 1..];
            }
        }
    }
    filled + rest
}

fn count<T>(index: &mut usize, value: &mut impl FnMut(usize) -> Option<T>) -> Option<T> {
    *index += 1;
    value(*index - 1)
}

#[cfg(test)]
mod tests {
    use super::{fill_in, internal_number, part_of};

    #[test]
    fn values_take_their_places() {
        let text = fill_in(
            "node %I of %S: %R, then %I, 50 %",
            |i| [7, 8].get(i).copied(),
            |_| Some(0.5),
            |_| Some("PLATE".into()),
        );
        assert_eq!(text, "node 7 of PLATE: 5e-1, then 8, 50 %");
        assert_eq!(fill_in("left %I", |_| None, |_| None, |_| None), "left %I");
    }

    #[test]
    fn numbers_in_parts_and_back() {
        let names = ["3".to_owned(), "Ball.12".to_owned()];
        assert_eq!([internal_number(&names, "", 3), internal_number(&names, "BALL", 12)], [1, 2]);
        assert_eq!(internal_number(&names, "BALL", 3), 0);
        assert_eq!(part_of(&names, 2), Some(("Ball", 12)));
        assert_eq!(part_of(&names, 3), None);
    }
}
