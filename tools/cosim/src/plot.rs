//! The figure of a recording.
use crate::Recording;

pub(crate) fn svg(_r: &Recording) -> Result<String, String> {
    Err(String::new())
}
