"""Synthetic bench experiments with a known answer, made independently of the FMU and of the Rust code.

`generator` integrates the motor, `effects` lists what a specimen may have that the preset lacks, `profiles` drives it,
`sensors` spoils what is read, `write` writes the set, `make` is the command: `python -m bench.make --seed 1 --out sets`.
"""
