"""Seeded faults and the findings of `motor-fmu validate` and of other free checkers.

`foreign` builds a small FMU from its own C source, `archive` changes archives, `faults` lists the faults, `checkers` runs the checkers,
and `table` writes the results into docs/validator.md. The C source and the two model descriptions are in the same folder.
"""
