//! The figure of a recording as a file.
use crate::{Error, Recording, plot};
use std::path::Path;

impl Recording {
    /// Draws the outputs over time as SVG: one panel for each unit, kelvin as degC if the FMU declares this display unit.
    ///
    /// # Errors
    /// [`Error::Plot`], [`Error::Io`].
    pub fn plot_svg(&self, path: &Path) -> Result<(), Error> {
        let svg = plot::svg(self).map_err(|reason| Error::Plot { path: path.to_owned(), reason })?;
        std::fs::write(path, svg).map_err(|source| Error::Io {
            action: "write",
            path: path.to_owned(),
            source,
        })
    }
}
