//! Data of the host routines (`vgetjobname` etc.): name and folder of the job, numbers of nodes and elements in their
//! parts, arrays that outlive a call, messages. All data belong to one thread, like a run.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::mem::ManuallyDrop;
use std::sync::Mutex;

use serde::Serialize;

use crate::state::archive::{Persist, StateArchive};

/// Severity of a message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Persist)]
#[serde(rename_all = "lowercase")]
pub enum MessageLevel {
    /// Information, from `LOP = 1`.
    #[default]
    Note,
    /// Warning, from `LOP = -1`.
    Warning,
    /// Error, from `LOP = -2` or `-3`.
    Error,
}

/// A message of a user subroutine (`xplb_abqerr`).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Persist)]
pub struct RoutineMessage {
    /// Whether the message is a note, a warning or an error.
    pub level: MessageLevel,
    /// Text of the message, as it is printed.
    pub text: String,
    /// Number of repetitions.
    pub times: u64,
}

/// Data of the job for its user subroutines.
#[derive(Clone, Debug, Default, Persist)]
pub struct JobInfo {
    /// Name of the job (`vgetjobname`).
    pub name: String,
    /// Folder of the deck, absolute (`vgetoutdir`).
    pub folder: String,
    /// Names of the nodes, `12` or `INSTANCE.12`. The internal number of a node is its index here, from 1.
    pub nodes: Vec<String>,
    /// Names of the elements.
    pub elements: Vec<String>,
}

/// Largest number of different messages.
const MOST: usize = 200;

/// An array that outlives a call: its bytes in aligned words, and the number of its entries.
type HostArray = (Box<[u64]>, i32);

static OPENING: Mutex<Vec<String>> = Mutex::new(Vec::new());

thread_local! {
    static ARRAYS: RefCell<BTreeMap<(u8, i32), HostArray>> = const { RefCell::new(BTreeMap::new()) };
    static JOB: RefCell<JobInfo> = RefCell::default();
    /// Never dropped, so that they can still be printed while the process exits.
    static MESSAGES: RefCell<ManuallyDrop<Vec<RoutineMessage>>> = const { RefCell::new(ManuallyDrop::new(Vec::new())) };
}

/// Sets the job of the user subroutines that this thread calls, and clears arrays and messages of the previous job.
pub fn begin_job(job: JobInfo) {
    JOB.with_borrow_mut(|j| *j = job);
    ARRAYS.with_borrow_mut(BTreeMap::clear);
    MESSAGES.with_borrow_mut(|list| list.clear());
    let opening = OPENING.lock().map(|warnings| warnings.clone()).unwrap_or_default();
    opening.into_iter().for_each(|text| report_message(MessageLevel::Warning, text));
}

/// Records a warning about a library that was being opened, on any thread; every later job repeats it.
pub fn report_opening(text: String) {
    if let Ok(mut warnings) = OPENING.lock()
        && !warnings.contains(&text)
        && warnings.len() < MOST
    {
        warnings.push(text);
    }
}

/// Returns and clears the messages since the job began.
pub fn take_messages() -> Vec<RoutineMessage> {
    MESSAGES.with_borrow_mut(|list| std::mem::take(&mut **list))
}

/// Passes the messages since the job began to `print`, also in a signal handler or while the process exits: it allocates
/// nothing, and skips them if they are being changed.
pub fn print_pending(mut print: impl FnMut(MessageLevel, &str)) {
    MESSAGES.with(|list| {
        let list = list.try_borrow().into_iter();
        list.for_each(|list| list.iter().for_each(|message| print(message.level, &message.text)));
    });
}

/// Archives the messages since the job began.
pub fn persist_messages(archive: &mut StateArchive<'_>) {
    MESSAGES.with_borrow_mut(|list| list.persist(archive));
}

/// Adds messages of user subroutines in another process.
pub fn add_messages(messages: Vec<RoutineMessage>) {
    for message in messages {
        for _ in 0..message.times {
            report_message(message.level, message.text.clone());
        }
    }
}

impl JobInfo {
    /// Returns the names of the nodes (kind 0) or of the elements (any other kind).
    pub fn names(&self, kind: i32) -> &[String] {
        if kind == 0 { &self.nodes } else { &self.elements }
    }
}

/// Archives the arrays of this thread.
pub fn persist_arrays(archive: &mut StateArchive<'_>) {
    let copied = |(key, array): (&(u8, i32), &HostArray)| (*key, (array.0.to_vec(), array.1));
    let mut list: Vec<_> = ARRAYS.with_borrow(|arrays| arrays.iter().map(copied).collect());
    list.persist(archive);
    if archive.reads() {
        let arrays = list.into_iter().map(|(key, (words, count))| (key, (words.into_boxed_slice(), count)));
        ARRAYS.with_borrow_mut(|all| *all = arrays.collect());
    }
}

/// Calls `read` with the data of the job of this thread.
pub fn with_job<R>(read: impl FnOnce(&JobInfo) -> R) -> R {
    JOB.with_borrow(read)
}

/// Adds a message for the end of the run; repetitions are counted.
pub fn report_message(level: MessageLevel, text: String) {
    MESSAGES.with_borrow_mut(|list| {
        if let Some(known) = list.iter_mut().find(|m| m.level == level && m.text == text) {
            known.times += 1;
        } else if list.len() < MOST {
            list.push(RoutineMessage { level, text, times: 1 });
        }
    });
}

/// Creates an array with a kind and a number, filled with `count` equal entries of `width` bytes, and returns its
/// address. An existing array keeps its content, and its address if its size does not change.
pub fn new_array(key: (u8, i32), count: i32, width: usize, value: &[u8]) -> *mut u64 {
    let words = (usize::try_from(count).unwrap_or(0) * width).div_ceil(8).max(1);
    let pattern: Vec<u8> = value.iter().copied().cycle().take(8).collect();
    let word = u64::from_ne_bytes(pattern.try_into().unwrap_or_default());
    ARRAYS.with_borrow_mut(|arrays| {
        let array = arrays.entry(key).or_insert_with(|| (vec![word; words].into_boxed_slice(), count));
        if array.1 != count {
            let mut longer = std::mem::take(&mut array.0).into_vec();
            longer.resize(words, word);
            *array = (longer.into_boxed_slice(), count);
        }
        array.0.as_mut_ptr()
    })
}

/// Returns the address of an array and the number of its entries.
pub fn array(key: (u8, i32)) -> Option<(*mut u64, i32)> {
    ARRAYS.with_borrow_mut(|arrays| arrays.get_mut(&key).map(|array| (array.0.as_mut_ptr(), array.1)))
}

/// Deletes the user array with this key; nothing happens if it does not exist.
pub fn delete_array(key: (u8, i32)) {
    ARRAYS.with_borrow_mut(|arrays| arrays.remove(&key));
}

/// Returns the internal number of a node or element from its instance and local number; 0 if there is none.
pub fn internal_number(names: &[String], part: &str, local: i32) -> i32 {
    let full_name = if part.is_empty() { local.to_string() } else { format!("{part}.{local}") };
    names.iter().position(|n| n.eq_ignore_ascii_case(&full_name)).map_or(0, |i| i as i32 + 1)
}

/// Returns instance and local number of a node or element from its internal number.
pub fn part_of(names: &[String], internal: i32) -> Option<(&str, i32)> {
    let name = names.get(usize::try_from(internal).ok()?.checked_sub(1)?)?;
    let (part, local) = name.rsplit_once('.').unwrap_or(("", name));
    Some((part, local.parse().ok()?))
}

/// Returns the principal values and directions of a symmetric tensor with direct components 11, 22, 33 and shear
/// components 12, 23, 31, by Jacobi rotations. Without shear out of the 1-2 plane, the two values in the plane come
/// first, in descending order, then the third; otherwise all are in descending order.
pub fn principal(direct: [f64; 3], shear: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let [s12, s23, s31] = shear;
    let mut a = [[direct[0], s12, s31], [s12, direct[1], s23], [s31, s23, direct[2]]];
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // The error is squared in each sweep; eight sweeps are far more than double precision needs.
    for (p, q) in [(0, 1), (1, 2), (0, 2)].into_iter().cycle().take(24) {
        if a[p][q] == 0.0 {
            continue;
        }
        let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
        let sine = tangent * cosine;
        for row in &mut a {
            (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
        }
        let turned = |x: [f64; 3], y: [f64; 3]| {
            ([0, 1, 2].map(|k| cosine * x[k] - sine * y[k]), [0, 1, 2].map(|k| sine * x[k] + cosine * y[k]))
        };
        (a[p], a[q]) = turned(a[p], a[q]);
        (axes[p], axes[q]) = turned(axes[p], axes[q]);
    }
    let values = [a[0][0], a[1][1], a[2][2]];
    let mut order = [0, 1, 2];
    let sorted = if s23 == 0.0 && s31 == 0.0 { &mut order[..2] } else { &mut order[..] };
    sorted.sort_by(|i, j| values[*j].total_cmp(&values[*i]));
    (order.map(|i| values[i]), order.map(|i| axes[i]))
}

/// Returns the text of `xplb_abqerr` with its values in place of `%I`, `%R` and `%S`.
pub fn fill_in(
    text: &str,
    mut integer: impl FnMut(usize) -> Option<i32>,
    mut real: impl FnMut(usize) -> Option<f64>,
    mut word: impl FnMut(usize) -> Option<String>,
) -> String {
    let mut filled = String::new();
    let (mut integers, mut reals, mut words) = (0, 0, 0);
    let mut remainder = text.trim_end();
    while let Some(percent) = remainder.find('%') {
        filled += &remainder[..percent];
        let code = remainder[percent + 1..].chars().next();
        let value = match code {
            Some('I' | 'i') => count(&mut integers, &mut integer).map(|i| i.to_string()),
            Some('R' | 'r') => count(&mut reals, &mut real).map(|r| format!("{r:e}")),
            Some('S' | 's') => count(&mut words, &mut word),
            _ => None,
        };
        match value {
            Some(value) => {
                filled += &value;
                remainder = &remainder[percent + 2..];
            }
            None => {
                filled.push('%');
                remainder = &remainder[percent + 1..];
            }
        }
    }
    filled + remainder
}

fn count<T>(index: &mut usize, value: &mut impl FnMut(usize) -> Option<T>) -> Option<T> {
    *index += 1;
    value(*index - 1)
}

#[cfg(test)]
mod tests {
    use super::{fill_in, internal_number, part_of, principal};

    #[test]
    fn principal_values_match_hand_calculation() {
        let (values, axes) = principal([5.0, 1.0, 9.0], [2.0, 0.0, 0.0]);
        let root = 8.0_f64.sqrt();
        for (value, expected) in values.into_iter().zip([3.0 + root, 3.0 - root, 9.0]) {
            assert!((value - expected).abs() < 1e-14, "{values:?}");
        }
        // Eigenvalue equation of the first axis.
        assert!((5.0 * axes[0][0] + 2.0 * axes[0][1] - values[0] * axes[0][0]).abs() < 1e-14);
        // All components 1: eigenvalues 3, 0, 0.
        let (values, axes) = principal([1.0; 3], [1.0; 3]);
        assert!((values[0] - 3.0).abs() < 1e-14 && values[1].abs() < 1e-14 && values[2].abs() < 1e-14, "{values:?}");
        assert!(axes[0].iter().all(|x| (x.abs() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-14));
    }

    #[test]
    fn placeholders_are_replaced_by_values() {
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
    fn internal_numbers_convert_both_ways() {
        let names = ["3".to_owned(), "Ball.12".to_owned()];
        assert_eq!([internal_number(&names, "", 3), internal_number(&names, "BALL", 12)], [1, 2]);
        assert_eq!(internal_number(&names, "BALL", 3), 0);
        assert_eq!(part_of(&names, 2), Some(("Ball", 12)));
        assert_eq!(part_of(&names, 3), None);
    }
}
