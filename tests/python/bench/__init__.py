"""Synthetic bench experiments with known answers, independent of the FMU and of the Rust code.

`generator` integrates the motor, `effects` lists possible effects, `rig` combines motor and bench, `profiles` generates drive cycles,
`sensors` adds noise and sensor faults, `detect` computes which effects are detectable, `write` writes the set, `make` is the command:
`python -m bench.make --seed 1 --out sets`.
"""
