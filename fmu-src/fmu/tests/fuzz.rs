//! Random calls of both C interfaces; `cargo xtask fuzz --calls N` makes more of them.

use crate::fuzzing;

#[test]
fn random_calls_cause_no_internal_failure() {
    let (calls, done) = fuzzing::run(250, 1, None);
    assert_eq!(calls, 100_000);
    // Neither all refused nor all accepted: the calls reach every mode.
    assert!(done > calls / 20 && done < calls, "{done} of {calls}");
}
