//! What the project stands on: each crate comes from crates.io, has a licence of `tests/deny.toml`, is none that is banned there, and
//! asks for no newer Rust than `Cargo.toml` names. Source: what cargo says of the locked crates of this platform.

use std::process::Command;

use serde_json::Value;

use crate::common::project;

fn packages() -> Vec<Value> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let host = Command::new(&cargo).args(["version", "--verbose"]).output().expect("cargo runs");
    let host = String::from_utf8_lossy(&host.stdout).into_owned();
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).expect("a platform").to_owned();
    let words = ["metadata", "--format-version", "1", "--locked", "--offline", "--filter-platform", &host];
    let output = Command::new(cargo).args(words).current_dir(project("")).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    all["packages"].as_array().expect("packages").clone()
}

/// Texts in quotes below a line of a file, up to the bracket that closes the list.
fn listed(text: &str, begin: &str) -> Vec<String> {
    let (_, list) = text.split_once(begin).expect("a list");
    let list = list.split("\n]").next().expect("an end");
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The three numbers of a version; what is left out is zero.
fn numbers(version: &str) -> [u64; 3] {
    let mut numbers = version.split('.').map(|n| n.parse().expect("a number"));
    [(); 3].map(|()| numbers.next().unwrap_or(0))
}

#[test]
fn crates_are_what_they_may_be() {
    let rules = std::fs::read_to_string(project("tests/deny.toml")).expect("rules");
    let (licences, banned) = (listed(&rules, "\nallow = ["), listed(&rules, "\ndeny = ["));
    assert!(licences.len() > 5 && banned.len() > 3);
    let packages = packages();
    assert!(packages.len() > 100, "{} packages", packages.len());
    let own = packages.iter().find(|p| p["name"] == "revolve").expect("the project");
    let own = numbers(own["rust_version"].as_str().expect("a version of Rust"));
    let mut newest = [0; 3];
    for package in packages.iter().filter(|p| p["name"] != "revolve") {
        let name = package["name"].as_str().expect("a name");
        assert!(!banned.iter().any(|b| b == name), "{name} is banned");
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
    println!("{} crates, the newest Rust that one asks for is {newest:?}", packages.len() - 1);
    // What the project's own code asks for is clippy's to find.
    assert!(newest <= own, "a crate asks for Rust {newest:?}, Cargo.toml names {own:?}");
}
