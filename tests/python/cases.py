"""Drive cycles of several tests: inputs over time, and modes."""

from dataclasses import dataclass

import numpy as np
from reference import Inputs


# Friction is off by default; every case has some of both kinds.
FRICTION = {"effect.coulomb_friction.tau_c": 9.83e-3, "effect.viscous_friction.k": 2e-6}


@dataclass(frozen=True)
class Knot:
    """Inputs at an instant; they are linear between two knots."""

    time: float
    inputs: Inputs


@dataclass(frozen=True)
class Case:
    """A run of the motor. `step` is the communication step."""

    name: str
    drive: str
    shaft: str
    step: float
    knots: tuple[Knot, ...]

    @property
    def steps(self) -> int:
        return round(self.knots[-1].time / self.step)

    @property
    def start(self) -> dict:
        """Start values for the FMU."""
        return {"drive_mode": self.drive, "mechanical_mode": self.shaft, **FRICTION, **vars(self.knots[0].inputs)}

    def stretches(self):
        """Each interval between two knots: inputs at its start, input derivatives, number of steps."""
        for a, b in zip(self.knots, self.knots[1:]):
            span = b.time - a.time
            slopes = {n: (getattr(b.inputs, n) - v) / span for n, v in vars(a.inputs).items()}
            yield a.inputs, Inputs(**slopes), round(span / self.step)


def constant(name, drive, shaft, step, stop, **inputs):
    """A case with constant inputs."""
    return Case(name, drive, shaft, step, (Knot(0.0, Inputs(**inputs)), Knot(stop, Inputs(**inputs))))


LOCKED_ROTOR = constant("locked-rotor current step", "voltage", "imposed_speed", 5e-5, 0.01, voltage=2.0)
FREE_SHAFT = constant("free-shaft voltage step under load", "voltage", "free_shaft", 1e-3, 0.5, voltage=36.0, load_torque=0.08)
ONE_HOUR = constant("one hour at 5 A", "current", "imposed_speed", 1.0, 3600.0, current_command=5.0, imposed_speed=300.0)

# Accelerate, hold, brake through zero into reverse, and stop; load, fan and room change on the way.
_TABLE = (
    # time, voltage, load, fan, room
    (0.00, 0.0, 0.00, 0.2, 298.15),
    (0.20, 36.0, 0.05, 0.2, 298.15),
    (0.50, 36.0, 0.15, 1.0, 299.15),
    (0.80, -12.0, 0.02, 0.5, 300.15),
    (1.00, 0.0, 0.00, 0.2, 298.15),
)
DRIVE_CYCLE = Case(
    "drive cycle",
    "voltage",
    "free_shaft",
    1e-3,
    tuple(
        Knot(t, Inputs(voltage=v, load_torque=load, fan_command=fan, ambient_temperature=room))
        for t, v, load, fan, room in _TABLE
    ),
)

CONSTANT = (LOCKED_ROTOR, FREE_SHAFT, ONE_HOUR)


def relative_error(found, reference):
    """Largest error of each state over a run, relative to the largest value; temperatures as rise above the start."""
    reference = np.asarray(reference, dtype=float)
    zero = np.array([0.0, 0.0, 0.0, *reference[0, 3:]])
    size = np.abs(reference - zero).max(axis=0)
    # A state that stays at zero (speed of a locked rotor) has no scale of its own: its error counts as it is.
    return np.abs(np.asarray(found) - reference).max(axis=0) / np.where(size > 0.0, size, 1.0)
