"""The blind suite: synthetic bench experiments whose truth has more physics than any model of the product, and their
evaluation.

`network` integrates a motor of seven thermal nodes, `structure` is what it has beyond two nodes, `laws` are the
effects, `draw` and `kinds`
draw a set, `mistakes` spoil its files, `files` writes it, `make` is the command: `python -m blind.make --seed 1 --out
sets`.

Evaluation of a program: `run` runs it on each set, `judge` compares one report with the truth, `score` computes rates
with intervals and
compares them with the criteria, `page` writes the tables.
"""
