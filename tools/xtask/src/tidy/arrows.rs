//! Allowed dependencies between crates: physics depends on neither FMI nor files, and cosim on none of the models.

use crate::{
    Outcome,
    workspace::{Package, Workspace},
};

/// A crate, and the crates of ours that it may need in the product.
const ALLOWED: &[(&str, &[&str])] = &[
    ("declare", &[]),
    // Only tests and benches need it: diffsol stays out of the product.
    ("reference", &[]),
    ("physics", &["declare"]),
    ("terms", &["physics"]),
    ("fmu", &["physics", "terms"]),
    ("units", &[]),
    ("delimited", &[]),
    ("describe", &["physics", "units", "delimited"]),
    ("least-squares", &[]),
    ("calibrate", &["physics", "terms", "least-squares", "units", "delimited"]),
    ("present", &[]),
    ("cosim", &["present", "units", "delimited"]),
    ("archive", &["describe", "cosim", "terms", "present", "units"]),
    ("study", &["physics", "describe", "present", "least-squares", "units", "delimited"]),
    ("cli", &["calibrate", "cosim", "archive", "study", "describe", "present", "units", "delimited"]),
    ("page", &["study", "describe", "present"]),
    // Benches alone: their needs are those of tests.
    ("bench", &[]),
    ("xtask", &["present"]),
];

/// Compares with `cargo metadata`.
pub fn check(workspace: &Workspace) -> Outcome {
    let wrong = wrong(&workspace.packages);
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}

fn allowed(name: &str) -> Option<&'static [&'static str]> {
    ALLOWED.iter().find(|(known, _)| *known == name).map(|(_, needs)| *needs)
}

/// Whether one crate lies below another, so that an arrow back would close a circle.
fn is_above(name: &str, other: &str) -> bool {
    allowed(name).unwrap_or_default().iter().any(|needed| *needed == other || is_above(needed, other))
}

fn wrong(packages: &[Package]) -> Vec<String> {
    let mut wrong = Vec::new();
    for package in packages {
        let name = package.name.as_str();
        let Some(may_need) = allowed(name) else {
            wrong.push(format!("{name} has no place in the order of crates; give it one in tidy/arrows.rs"));
            continue;
        };
        for needed in package.needs.iter().map(String::as_str).filter(|n| !may_need.contains(n)) {
            wrong.push(format!("{name} -> {needed} is not allowed; {name} may need {}", list(may_need)));
        }
        // Tests may reach sideways (a bench of the C interface needs a client), never upwards.
        let itself = |n: &&str| *n == name;
        for needed in package.needs_in_tests.iter().map(String::as_str).filter(|n| !itself(n)) {
            if is_above(needed, name) {
                wrong
                    .push(format!("the tests of {name} -> {needed} point upwards; {needed} is above {name}"));
            }
        }
    }
    wrong
}

fn list(names: &[&str]) -> String {
    if names.is_empty() { "no crate of ours".into() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_against_the_order_are_named() {
        let owned = |names: &[&str]| names.iter().map(|n| String::from(*n)).collect::<Vec<_>>();
        for (name, needs, needs_in_tests, sentence) in [
            ("archive", &["describe", "cosim"][..], &[][..], None),
            ("fmu", &["physics"], &["cosim", "fmu"], None),
            (
                "physics",
                &["declare", "fmu"],
                &[],
                Some("physics -> fmu is not allowed; physics may need declare"),
            ),
            (
                "cosim",
                &["physics"],
                &[],
                Some("cosim -> physics is not allowed; cosim may need present, units, delimited"),
            ),
            (
                "cosim",
                &[],
                &["archive"],
                Some("the tests of cosim -> archive point upwards; archive is above cosim"),
            ),
            (
                "declare",
                &[],
                &["cli"],
                Some("the tests of declare -> cli point upwards; cli is above declare"),
            ),
            (
                "gadget",
                &[],
                &[],
                Some("gadget has no place in the order of crates; give it one in tidy/arrows.rs"),
            ),
        ] {
            let (needs, needs_in_tests) = (owned(needs), owned(needs_in_tests));
            let package = Package { name: name.into(), needs, needs_in_tests, has_benches: false };
            assert_eq!(wrong(&[package]), owned(sentence.as_slice()), "{name}");
        }
    }

    #[test]
    fn the_order_has_no_circle() {
        for (name, needs) in ALLOWED {
            assert!(!is_above(name, name), "{name}");
            assert!(needs.iter().all(|n| allowed(n).is_some()), "{name}");
        }
    }
}
