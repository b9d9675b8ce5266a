//! The lock of value references: once given, a number means the same variable for good.

use physics::model::Declaration;
use std::collections::BTreeMap;

/// Why the lock and the declarations do not go together: one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct LockError(pub String);

/// The lock's new text: all that `old` holds, retired variables too, and what the declarations add.
pub fn update(old: &str, declarations: &[&Declaration]) -> Result<String, LockError> {
    let mut taken: BTreeMap<(String, u32), String> = BTreeMap::new();
    for (n, line) in old.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty()) {
        let mut words = line.split_whitespace();
        let (Some(model), Some(Ok(reference)), Some(name)) =
            (words.next(), words.next().map(str::parse), words.next())
        else {
            return Err(LockError(format!(
                "value-references.lock:{}: not a line of model, number, name",
                n + 1
            )));
        };
        taken.insert((model.to_string(), reference), name.to_string());
    }
    for declaration in declarations {
        for entry in &declaration.entries {
            let key = (declaration.name.to_string(), entry.value_reference);
            let holder = taken.entry(key).or_insert_with(|| entry.name.clone());
            if *holder != entry.name {
                return Err(LockError(format!(
                    "value-references.lock: {} {} belongs to {holder} for good and cannot become {}",
                    declaration.name, entry.value_reference, entry.name
                )));
            }
        }
    }
    let mut text = String::from(
        "# Value references once given are never given again. Made by `cargo xtask describe`.\n",
    );
    for ((model, reference), name) in taken {
        text.push_str(&format!("{model} {reference} {name}\n"));
    }
    Ok(text)
}
