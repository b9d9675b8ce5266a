//! The validator of archives.

use super::super::Mutant;

const fn mutant(
    name: &'static str,
    file: &'static str,
    text: &'static str,
    replacement: &'static str,
    breaks: &'static str,
) -> Mutant {
    Mutant { name, noticed_by: &["archive"], file, text, replacement, breaks }
}

/// All of them.
pub const MUTANTS: &[Mutant] = &[
    mutant(
        "validator-zero-factor",
        "tools/archive/src/validate/semantics/units.rs",
        "*f == 0.0 || !f.is_finite()",
        "!f.is_finite()",
        "a display unit with a factor of zero passes",
    ),
    mutant(
        "validator-display-of-other-unit",
        "tools/archive/src/validate/semantics/units.rs",
        "!known.contains(display)",
        "false",
        "an undefined display unit passes",
    ),
    mutant(
        "validator-start-above-max",
        "tools/archive/src/validate/semantics/values.rs",
        "nominal > 0.0 && nominal.is_finite()",
        "true",
        "a nominal value of zero passes",
    ),
    mutant(
        "validator-alias-constant",
        "tools/archive/src/validate/semantics/aliases.rs",
        "constants != 0 && constants != set.len()",
        "false",
        "a constant with a variable alias passes",
    ),
    mutant(
        "validator-unit-of-alias",
        "tools/archive/src/validate/semantics/aliases.rs",
        "unit(v) != unit(first)",
        "false",
        "aliases of different units pass",
    ),
    mutant(
        "validator-initial-unknown-missing",
        "tools/archive/src/validate/semantics/initial_unknowns.rs",
        "expected.contains(&i) && !listed.contains(&i)",
        "false",
        "a missing initial unknown passes",
    ),
    mutant(
        "validator-initial-unknown-order",
        "tools/archive/src/validate/semantics/initial_unknowns.rs",
        "model.version == Version::Fmi2 && i < last",
        "false",
        "initial unknowns without order pass",
    ),
    mutant(
        "validator-structured-name",
        "tools/archive/src/validate/semantics/names.rs",
        "structured && !is_structured(name)",
        "false",
        "a name against its convention passes",
    ),
    mutant(
        "validator-type-kind",
        "tools/archive/src/validate/semantics/types.rs",
        "t.type_name != v.type_name",
        "false",
        "a declared type of another kind passes",
    ),
    mutant(
        "validator-terminal-path",
        "tools/archive/src/validate/terminals.rs",
        r#"base.split('/').any(|part| part == "..")"#,
        "false",
        "an icon outside of the archive passes",
    ),
    mutant(
        "validator-symbol-definition",
        "tools/archive/src/validate/symbols.rs",
        "s.is_global() && s.is_definition()",
        "false",
        "no exported function of a macOS library is seen",
    ),
];
