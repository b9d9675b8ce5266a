"""The rigs: which motor stands on the bench, how hard it is driven, and what of it is imposed and read.

The public sets are made on `PUBLIC`. Other motors are scaled from it by two numbers, so that they run at the same temperatures:
their heat capacity (`size`) and their torque constant (`winding`: more turns). With lengths going as size^(1/3),

    C ~ size     G ~ 1/R_wh ~ size^(2/3)     k_t ~ winding     R ~ winding^2 / size^(5/3)     i ~ (G/R)^(1/2)     w ~ size^(-1/3)

*Source*: similarity of motors of one kind: the motor constant k_t/R^(1/2) goes as length^(5/2), loss per surface is the same.
"""

from dataclasses import dataclass, field

import numpy as np

COLUMNS = {"current": "current_A", "voltage": "voltage_V", "power": "electrical_power_W"}
SPEED, FAN, AMBIENT = "speed_rad_per_s", "fan_command_1", "ambient_temperature_degC"
TORQUE, WINDING, HOUSING = "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"
TEMPERATURE_SENSORS = {"winding_sensor": WINDING, "housing_sensor": HOUSING}

# The declared motor of the public sets, SI units.
NOMINAL = {
    "motor.R_ref": 0.386,
    "motor.T_ref": 298.15,
    "motor.alpha": 0.0039,
    "motor.k_t": 0.0276,
    "motor.alpha_mag": -0.0012,
    "thermal.R_wh": 0.21,
    "thermal.C_w": 10.05,
    "thermal.C_h": 159.0,
    "conductance.G_still": 0.1351,
    "conductance.G_forced": 0.35,
    "effect.coulomb_friction.tau_c": 0.005,
    "effect.coulomb_friction.w_small": 5.0,
}
# How far specimens scatter around it: relative standard deviations.
PRIOR = {
    "motor.R_ref": 0.03,
    "motor.k_t": 0.02,
    "effect.coulomb_friction.tau_c": 0.3,
    "thermal.R_wh": 0.15,
    "thermal.C_w": 0.1,
    "conductance.G_still": 0.1,
    "conductance.G_forced": 0.15,
    "thermal.C_h": 0.05,
}
# What each nominal value goes with, as exponents of the units of a rig.
GOES_WITH = {
    "motor.R_ref": {"voltage": 1, "current": -1},
    "motor.k_t": {"torque": 1, "current": -1},
    "thermal.R_wh": {"conductance": -1},
    "thermal.C_w": {"capacity": 1},
    "thermal.C_h": {"capacity": 1},
    "conductance.G_still": {"conductance": 1},
    "conductance.G_forced": {"conductance": 1},
    "effect.coulomb_friction.tau_c": {"torque": 1},
}
SIZE, WINDING_FACTOR = (0.25, 6.0), (0.5, 3.0)  # lowest and highest
DIGITS = 4  # of a nominal value, as a data sheet has them


@dataclass(frozen=True)
class Layout:
    """What drives the motor, and which columns are imposed and measured."""

    drive: str

    @property
    def inputs(self) -> tuple:
        """At standstill the speed is not a column."""
        return (COLUMNS[self.drive], *(() if self.drive == "power" else (SPEED,)), FAN, AMBIENT)

    @property
    def outputs(self) -> tuple:
        answer = {"current": (COLUMNS["voltage"], TORQUE), "voltage": (COLUMNS["current"], TORQUE), "power": ()}
        return (*answer[self.drive], WINDING, HOUSING)

    def allows(self, law) -> bool:
        """Whether an effect can act: at standstill only thermal effects, and drive loss only there."""
        if self.drive != "power":
            return law.drive in (None, self.drive)
        electric = law.port in ("drag_torque", "terminal_voltage", "winding_resistance", "torque_constant")
        return not electric and law.driver not in ("speed", "current", "load_torque")


LAYOUTS = {drive: Layout(drive) for drive in COLUMNS}


@dataclass(frozen=True)
class Rig:
    """A motor on its bench."""

    layout: Layout = LAYOUTS["current"]
    units: dict = field(default_factory=dict)  # of this rig, in those of the public one; what is missing is 1

    def scaled(self, value: float, exponents: dict) -> float:
        """A quantity of the public rig, scaled to this one."""
        for unit, exponent in exponents.items():
            value *= self.units.get(unit, 1.0) ** exponent
        return value

    @property
    def nominal(self) -> dict:
        if not self.units:
            return NOMINAL
        return NOMINAL | {name: float(f"{self.scaled(NOMINAL[name], exponents):.{DIGITS}g}") for name, exponents in GOES_WITH.items()}

    @property
    def prior(self) -> dict:
        """At standstill the electrical and mechanical parameters are not observable."""
        thermal = ("thermal.", "conductance.")
        return {name: sigma for name, sigma in PRIOR.items() if self.layout.drive != "power" or name.startswith(thermal)}


PUBLIC = Rig()


def draw_units(rng) -> dict:
    """A smaller or larger motor, with a random number of turns."""
    size, winding = (float(np.exp(rng.uniform(*np.log(limits)))) for limits in (SIZE, WINDING_FACTOR))
    conductance, resistance = size ** (2 / 3), winding**2 / size ** (5 / 3)
    current = (conductance / resistance) ** 0.5
    units = {"capacity": size, "conductance": conductance, "current": current, "torque": winding * current}
    return units | {"voltage": resistance * current, "speed": size ** (-1 / 3), "power": conductance}


def draw_specimen(rng, rig: Rig = PUBLIC) -> dict:
    """The parameters with a prior, of one motor."""
    scatter = {name: np.clip(rng.standard_normal(), -SCATTER_LIMIT, SCATTER_LIMIT) for name in rig.prior}
    return {name: float(rig.nominal[name] * (1.0 + rig.prior[name] * scatter[name])) for name in rig.prior}


SCATTER_LIMIT = 2.5  # standard deviations; keeps every parameter positive
