//! The resource folder of an archive.

use crate::{FILE_NAME, TermsError, TermsFile, load};
use physics::resources::Resources;
use std::path::Path;

/// Reads the resource folder; each file is optional.
///
/// # Errors
/// A file that cannot be read or is invalid, in one sentence.
pub fn of_resources(folder: &Path) -> Result<Resources, TermsError> {
    let there = |name: &str| Some(folder.join(name)).filter(|path| path.try_exists().unwrap_or(true));
    let terms = there(FILE_NAME).map(|path| TermsFile::load(&path)?.terms()).transpose()?;
    let load = there(load::FILE_NAME).map(|path| load::LoadFile::load(&path)?.table()).transpose()?;
    Ok(Resources { terms: terms.unwrap_or_default(), load })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = r#"{"format": "motor-fmu effects 1", "terms": [
        {"port": "drag_torque", "coefficient": 1.2e-3}, {"port": "winding_heat", "coefficient": 2}]}"#;
    const LOAD: &str = r#"{"format": "motor-fmu load 1", "period": 1, "rows": [[0, 1, 2]]}"#;

    #[test]
    fn a_folder_without_the_file_has_no_terms() {
        let folder = std::env::temp_dir().join(format!("motor-fmu-terms-{}", std::process::id()));
        assert_eq!(of_resources(&folder), Ok(Resources::default()), "nor a missing folder");
        std::fs::create_dir_all(&folder).unwrap();
        assert_eq!(of_resources(&folder), Ok(Resources::default()));
        std::fs::write(folder.join(FILE_NAME), TWO).unwrap();
        let two = of_resources(&folder).map(|found| found.terms.len());
        assert!(two.is_ok() && of_resources(&folder).unwrap().load.is_none());
        std::fs::write(folder.join(load::FILE_NAME), LOAD).unwrap();
        assert_eq!(of_resources(&folder).unwrap().load.unwrap().torques, [1.0]);
        std::fs::write(folder.join(FILE_NAME), "{").unwrap();
        let broken = of_resources(&folder);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(two, Ok(2));
        assert!(broken.unwrap_err().to_string().contains("effects.json:1:"));
    }
}
