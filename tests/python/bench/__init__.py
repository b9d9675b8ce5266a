"""Synthetic bench experiments with a known answer, made independently of the FMU and of the Rust code.

`generator` integrates the motor, `effects` lists what a specimen may have that the preset lacks, `rig` says which motor stands on
which bench, `profiles` drives it, `sensors` spoils what is read, `detect` says what can be seen, `write` writes the set, `make` is
the command: `python -m bench.make --seed 1 --out sets`.

What a program says of sets: `run` runs it on each, `judge` compares one report with the truth, `score` compares rates with criteria,
`page` writes the table.
"""
