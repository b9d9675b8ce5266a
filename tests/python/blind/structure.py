"""Physics of a specimen beyond two nodes: pieces with a strength each, and the true statements that a report could
make about them.
"""

import numpy as np

# Piece: lowest and highest strength, whether the sign is random.
PIECES = {
    "end_winding": (0.1, 0.6, False),
    "stator": (0.2, 1.0, False),
    "rotor": (0.1, 1.0, False),
    "housing_ends": (0.1, 0.6, True),
    "convection": (0.2, 1.0, False),
    "fan_exponent": (0.05, 0.2, True),
    "grease": (0.1, 0.7, False),
    "sensor_seat": (0.2, 1.0, False),
    "sensor_lag": (2.0, 15.0, False),
    "moved": (0.1, 1.0, True),
}
# (ports, listed effects) that are true of a piece: such a report is no false alarm.
TRUE_OF = {
    "end_winding": (("heat_capacity", "winding_housing_resistance", "winding_sensor"), ("stator_node",)),
    "stator": (("heat_capacity", "winding_housing_resistance"), ("stator_node",)),
    "rotor": (("heat_capacity", "torque_constant"), ("stator_node",)),
    "housing_ends": (("heat_capacity", "housing_sensor", "housing_heat"), ("stator_node",)),
    "convection": (("housing_ambient_conductance",), ("natural_convection",)),
    "fan_exponent": (("fan_flow", "housing_ambient_conductance"), ("fan_exponent",)),
    "grease": (("drag_torque",), ("lubricant_friction",)),
    "sensor_seat": (("winding_sensor", "housing_sensor"), ("winding_sensor_stem_loss", "housing_sensor_stem_loss")),
    "sensor_lag": (("winding_sensor", "housing_sensor"), ("winding_sensor_lag", "housing_sensor_lag")),
    "moved": (("winding_sensor", "housing_sensor"), ("winding_sensor_offset", "housing_sensor_offset")),
}
LARGEST = 5.0  # sigma of the sensors
NONE_IN = 0.25  # fraction of sets without structure error


def draw(rng, runs: int, without=()) -> dict:
    """Two to five pieces at the strengths that a whole structure has; those of `without` would make an effect of the
    set ambiguous.
    """
    names = [p for p in PIECES if p not in without]
    chosen = rng.choice(names, int(rng.integers(2, 6)), replace=False)
    pieces: dict = {}
    for name in sorted(map(str, chosen)):
        low, high, signed = PIECES[name]
        size = float(rng.uniform(low, high) * (rng.choice([-1.0, 1.0]) if signed else 1.0))
        pieces[name] = {run: tuple(size * rng.standard_normal(2)) for run in range(runs)} if name == "moved" else size
    return pieces


def level(rng) -> float:
    """Size of the structure error that a set aims at, in standard deviations of the sensors."""
    return 0.0 if rng.random() < NONE_IN else float(rng.uniform(0.3, LARGEST))


def true_statements(pieces: dict) -> tuple:
    """Ports and listed effects that are true of these pieces."""
    ports = sorted({port for piece in pieces for port in TRUE_OF[piece][0]})
    return ports, sorted({name for piece in pieces for name in TRUE_OF[piece][1]})
