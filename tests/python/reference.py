"""The motor's equations once more, written from the design and not from the Rust code, for SciPy's integrators.

    voltage drive    L di/dt = v - R(T_w) i - k_t(T_h) w
    current drive    i = i_command
    free shaft       J dw/dt = k_t(T_h) i - drag(w) - load
    imposed speed    w = w_imposed
    winding          C_w dT_w/dt = R(T_w) i^2 + heat - (T_w - T_h) / R_wh
    housing          C_h dT_h/dt = (T_w - T_h) / R_wh + drag(w) w - G (T_h - T_a)
    drag(w) = tau_c tanh(w / w_small) + k_v w
    R(T) = R_ref [1 + alpha (T - T_ref)]        k_t(T) = k_t,ref [1 + alpha_mag (T - T_ref)]
    G = G_still + G_forced n^0.8
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

RTOL = 1e-10
# Absolute tolerances: far below what 1e-10 of each state's range in the tests is.
ATOL = np.array([1e-11, 1e-10, 1e-9, 1e-10, 1e-10])
STATES = ("current", "shaft_angle", "shaft_speed", "winding_temperature", "housing_temperature")
PARAMETERS = {
    "R_ref": "motor.R_ref",
    "T_ref": "motor.T_ref",
    "alpha": "motor.alpha",
    "L": "motor.L",
    "k_t": "motor.k_t",
    "alpha_mag": "motor.alpha_mag",
    "J": "motor.J",
    "R_wh": "thermal.R_wh",
    "C_w": "thermal.C_w",
    "C_h": "thermal.C_h",
    "G_still": "conductance.G_still",
    "G_forced": "conductance.G_forced",
    "tau_c": "effect.coulomb_friction.tau_c",
    "w_small": "effect.coulomb_friction.w_small",
    "k_v": "effect.viscous_friction.k",
}


@dataclass(frozen=True)
class Inputs:
    """Inputs at an instant, or their slopes."""

    voltage: float = 0.0
    current_command: float = 0.0
    load_torque: float = 0.0
    imposed_speed: float = 0.0
    fan_command: float = 0.0
    ambient_temperature: float = 298.15
    heat_power: float = 0.0

    def after(self, slopes: "Inputs", t: float) -> "Inputs":
        """These inputs after `t` seconds on their lines."""
        return Inputs(*(getattr(self, n) + t * getattr(slopes, n) for n in self.__dataclass_fields__))


REST = Inputs(ambient_temperature=0.0)


@dataclass
class Motor:
    """A motor with the parameters of an FMU, its modes, and its state."""

    p: dict
    drive: str = "voltage"
    shaft: str = "free_shaft"
    y: np.ndarray = field(default_factory=lambda: np.zeros(5))

    @classmethod
    def like(cls, instance, drive="voltage", shaft="free_shaft", ambient=298.15) -> "Motor":
        """With the parameters of an FMU's instance, at rest at the ambient temperature."""
        values = instance.get(*PARAMETERS.values())
        return cls(dict(zip(PARAMETERS, values)), drive, shaft, np.array([0.0, 0.0, 0.0, ambient, ambient]))

    def resistance(self, t_w):
        return self.p["R_ref"] * (1.0 + self.p["alpha"] * (t_w - self.p["T_ref"]))

    def torque_constant(self, t_h):
        return self.p["k_t"] * (1.0 + self.p["alpha_mag"] * (t_h - self.p["T_ref"]))

    def drag(self, w):
        return self.p["tau_c"] * np.tanh(w / self.p["w_small"]) + self.p["k_v"] * w

    def conductance(self, n):
        return self.p["G_still"] + self.p["G_forced"] * n**0.8

    def rates(self, y, u: Inputs, slopes: Inputs):
        """Time derivatives of the states."""
        i, _, w, t_w, t_h = y
        p, k = self.p, self.torque_constant(t_h)
        electric = (u.voltage - self.resistance(t_w) * i - k * w) / p["L"]
        mechanic = (k * i - self.drag(w) - u.load_torque) / p["J"]
        across = (t_w - t_h) / p["R_wh"]
        leaving = self.conductance(u.fan_command) * (t_h - u.ambient_temperature)
        return np.array(
            [
                slopes.current_command if self.drive == "current" else electric,
                w,
                slopes.imposed_speed if self.shaft == "imposed_speed" else mechanic,
                (self.resistance(t_w) * i**2 + u.heat_power - across) / p["C_w"],
                (across + self.drag(w) * w - leaving) / p["C_h"],
            ]
        )

    def impose(self, u: Inputs):
        """Takes over the states that an ideal source decides."""
        if self.drive == "current":
            self.y[0] = u.current_command
        if self.shaft == "imposed_speed":
            self.y[2] = u.imposed_speed

    def advance(self, u: Inputs, slopes: Inputs, times, method="Radau"):
        """Integrates over one smooth stretch; `times` count from its start. The states at them, one per row.

        Over a few time constants L / R an explicit method needs less time than Radau with its Jacobian.
        """
        self.impose(u)
        solution = solve_ivp(
            lambda t, y: self.rates(y, u.after(slopes, t), slopes),
            (0.0, times[-1]),
            self.y,
            method=method,
            t_eval=times,
            rtol=RTOL,
            atol=ATOL,
        )
        assert solution.success, solution.message
        self.y = solution.y[:, -1].copy()
        return solution.y.T
