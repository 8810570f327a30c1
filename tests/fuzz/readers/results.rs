//! Folders of results read by `report` and `chart`, in which one file of a complete run is replaced.
use std::path::PathBuf;
use std::sync::OnceLock;

use revolve::job;
use revolve::output::JobFiles;
use revolve::report;
use revolve::user::Routines;

const ENDINGS: [&str; 6] = [".json", ".pvd", "_history.csv", "_0001.vtu", "_sweep.csv", "_study.json"];

/// Returns a folder with the results of a short run.
fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        revolve::model::silence_caught_panics();
        let folder = super::folder();
        let deck = include_str!("../../../input/taylor_copper.inp").replace("80.e-6", "1.e-6");
        let few = [("nr".to_owned(), "2".to_owned()), ("nz".to_owned(), "4".to_owned())];
        let prepared = job::prepare_text("fuzz.inp", &deck, &few, &Routines::none());
        let job = JobFiles { folder: folder.clone(), name: "job".into() };
        job::run_to_files(&prepared, &job, &mut |_| {}).expect("files");
        // Keep a few frames only.
        for entry in std::fs::read_dir(&folder).expect("a folder").flatten() {
            let name = entry.file_name().into_string().unwrap_or_default();
            if name.ends_with(".vtu") && !name.ends_with("_0000.vtu") && !name.ends_with("_0001.vtu") {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        let list = std::fs::read_to_string(folder.join("job.pvd")).expect("a list");
        let kept = |line: &&str| !line.contains("DataSet") || line.contains("_0000") || line.contains("_0001");
        let few: Vec<&str> = list.lines().filter(kept).collect();
        std::fs::write(folder.join("job.pvd"), few.join("\n") + "\n").expect("a list");
        folder
    })
}

/// Reads the data as a file of results; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    let Some((which, content)) = data.split_first() else { return };
    let folder = folder();
    let path = folder.join(format!("job{}", ENDINGS[usize::from(*which) % ENDINGS.len()]));
    let before = std::fs::read(&path).ok();
    std::fs::write(&path, content).expect("a file");
    if let Ok(page) = report::gather(folder) {
        let _ = report::html(&page);
    }
    match before {
        Some(bytes) => std::fs::write(&path, bytes).expect("a file"),
        None => std::fs::remove_file(&path).expect("removed"),
    }
}
