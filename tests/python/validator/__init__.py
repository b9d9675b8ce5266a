"""Seeded faults: what `motor-fmu validate` finds, and what other free checkers do.

`foreign` builds a small FMU from its own C source, `archive` changes archives, `faults` lists the faults, `checkers` runs the checkers,
and `table` writes their answers into docs/validator.md. The C source and the two model descriptions lie beside them.
"""
