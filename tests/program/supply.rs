//! Dependencies: each crate comes from crates.io, has a licence of `tests/deny.toml` and needs no newer Rust than
//! `Cargo.toml` states; the program contains none that is banned there. Source: the metadata of cargo for the locked
//! crates of this platform.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

use crate::common::project;

/// Returns the packages of the workspace, and the names of the crates in the program.
fn packages() -> (Vec<Value>, BTreeSet<String>) {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let host = Command::new(&cargo).args(["version", "--verbose"]).output().expect("cargo runs");
    let host = String::from_utf8_lossy(&host.stdout).into_owned();
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).expect("a platform").to_owned();
    let words = ["metadata", "--format-version", "1", "--locked", "--offline", "--filter-platform", &host];
    let output = Command::new(cargo).args(words).current_dir(project("")).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = all["packages"].as_array().expect("packages").clone();
    let nodes = all["resolve"]["nodes"].as_array().expect("a graph");
    let dependencies: BTreeMap<&str, &Value> =
        nodes.iter().map(|node| (node["id"].as_str().expect("an id"), &node["dependencies"])).collect();
    let own = packages.iter().find(|p| p["name"] == "revolve").expect("the project");
    let (mut open, mut reached) = (vec![own["id"].as_str().expect("an id")], BTreeSet::new());
    while let Some(id) = open.pop() {
        if reached.insert(id) {
            open.extend(dependencies[id].as_array().into_iter().flatten().filter_map(Value::as_str));
        }
    }
    let is_reached = |package: &&Value| package["id"].as_str().is_some_and(|id| reached.contains(id));
    let names = packages.iter().filter(is_reached).filter_map(|p| p["name"].as_str()).map(str::to_owned).collect();
    (packages, names)
}

/// Returns the first quoted text of each line of a list, from the line after `begin` to the closing bracket.
fn listed(text: &str, begin: &str) -> Vec<String> {
    let (_, list) = text.split_once(begin).expect("a list");
    let list = list.split("\n]").next().expect("an end");
    list.lines().filter_map(|line| line.split('"').nth(1)).map(str::to_owned).collect()
}

/// Returns the three numbers of a version; missing ones are zero.
fn numbers(version: &str) -> [u64; 3] {
    let mut numbers = version.split('.').map(|n| n.parse().expect("a number"));
    [(); 3].map(|()| numbers.next().unwrap_or(0))
}

/// Returns whether a package is a member of the workspace.
fn is_own(package: &Value) -> bool {
    package["name"].as_str().is_some_and(|name| name == "revolve" || name.starts_with("revolve-"))
}

#[test]
fn crates_have_allowed_sources_licences_and_versions() {
    let rules = std::fs::read_to_string(project("tests/deny.toml")).expect("rules");
    let (licences, banned) = (listed(&rules, "\nallow = ["), listed(&rules, "\ndeny = ["));
    assert!(licences.len() > 5 && banned.len() > 3);
    let (packages, of_program) = packages();
    assert!(of_program.len() > 100 && of_program.contains("rayon"), "{of_program:?}");
    if let Some(name) = banned.iter().find(|name| of_program.contains(*name)) {
        panic!("{name} is banned");
    }
    assert!(packages.len() > 100, "{} packages", packages.len());
    let own = packages.iter().find(|p| p["name"] == "revolve").expect("the project");
    let own = numbers(own["rust_version"].as_str().expect("a version of Rust"));
    let mut newest = [0; 3];
    for package in packages.iter().filter(|p| !is_own(p)) {
        let name = package["name"].as_str().expect("a name");
        let from = package["source"].as_str().unwrap_or("a path");
        assert_eq!(from, "registry+https://github.com/rust-lang/crates.io-index", "{name}");
        let licence = package["license"].as_str().unwrap_or_default().replace('/', " OR ");
        let allowed = |one: &str| licences.iter().any(|l| l == one.trim_matches(['(', ')', ' ']));
        let met = licence.split(" AND ").all(|part| part.split(" OR ").any(allowed));
        assert!(met, "{name}: {licence}");
        if let Some(version) = package["rust_version"].as_str() {
            newest = newest.max(numbers(version));
        }
    }
    let count = packages.iter().filter(|p| !is_own(p)).count();
    println!("{count} crates, the newest Rust that one needs is {newest:?}");
    // Clippy checks the Rust version of the project's own code.
    assert!(newest <= own, "a crate needs Rust {newest:?}, Cargo.toml names {own:?}");
}
