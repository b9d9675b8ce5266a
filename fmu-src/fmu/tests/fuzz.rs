//! A few seconds of calls without order; `cargo xtask fuzz --seconds N` plays longer.

use crate::fuzzing;

#[test]
fn nothing_that_is_called_breaks_it() {
    let (calls, done) = fuzzing::play(3.0, 1, None);
    assert!(calls > 1000, "{calls}");
    // Neither all refused nor all taken: the dice reach every mode.
    assert!(done > calls / 20 && done < calls, "{done} of {calls}");
}
