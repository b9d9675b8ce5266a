"""The two-node motor without structure and laws: `Network` with two states instead of seven, several times faster.

*Integrates* with the Runge-Kutta steps of `Network`: the readings are equal except for rounding.
"""

import numpy as np
from bench.rig import COLUMNS, HOUSING, TORQUE, WINDING

from .network import T_REF, Network

BLOCK = 1000  # substeps whose coefficients are computed at once


class TwoNode(Network):
    """`least`: lower bound of the substeps between rows, those of the network that it is compared with."""

    def __init__(self, columns, drive: str, least=None):
        super().__init__(columns, drive)
        self.least = least

    def substeps(self, u):
        own = super().substeps(u)
        return own if self.least is None else np.maximum(own, self.least[: len(own)])

    def terminals(self, T_w, T_h, drive, w):
        """Resistance, torque constant, current."""
        R = self.R_ref * (1.0 + self.alpha * (T_w - T_REF))
        k_t = self.k_t * (1.0 + self.alpha_mag * (T_h - T_REF))
        if self.drive == "voltage":
            return R, k_t, (drive - k_t * w) / R
        return R, k_t, drive if self.drive == "current" else np.zeros_like(drive)

    def coefficients(self, u):
        """A and c of the rates A y + B y[::-1] + c of winding and housing, without the copper loss of a motor at a
        voltage, which is not linear in y; drive and speed.
        """
        drive, w, n, T_a = np.moveaxis(u, 1, 0)[1:]
        loss = self.R_ref * drive**2 if self.drive == "current" else np.zeros_like(drive)
        fixed = drive if self.drive == "power" else loss * (1.0 - self.alpha * T_REF)
        G = np.maximum(self.G_still + self.G_forced * np.maximum(n, 0.0) ** 0.8, 0.0)
        friction = self.tau_c * np.tanh(w / self.w_small) * w
        A = np.stack([(loss * self.alpha - 1.0 / self.R_wh) / self.C_w, -(1.0 / self.R_wh + G) / self.C_h], axis=1)
        return A, np.stack([fixed / self.C_w, (friction + G * T_a) / self.C_h], axis=1), drive, w

    def simulate(self) -> list:
        """Per column: readings of an ideal bench by column name."""
        u = self.table()
        counts, step = self.substeps(u), np.diff(u, axis=0)
        row = np.repeat(np.arange(len(counts)), counts)
        sub = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
        B = np.stack([1.0 / (self.R_wh * self.C_w), 1.0 / (self.R_wh * self.C_h)])

        def rates(y, A, c, drive, w):
            dy = A * y + B * y[::-1] + c
            if self.drive == "voltage":
                R, _, i = self.terminals(*y, drive, w)
                dy[0] += R * i * i / self.C_w
            return dy

        y = np.tile(u[0, 4], (2, 1))
        states = np.zeros((len(u), *y.shape))
        for first in range(0, len(row), BLOCK):
            part = slice(first, first + BLOCK)
            rows, each = row[part], counts[row[part]]
            stages = []
            for fraction in (0.0, 0.5, 1.0):
                inputs = u[rows] + ((sub[part] + fraction) / each)[:, None, None] * step[rows]
                stages.append(zip(*self.coefficients(inputs)))
            for k, h, begin, middle, end in zip(rows, step[rows, 0] / each[:, None], *stages):
                k1 = rates(y, *begin)
                k2 = rates(y + 0.5 * h * k1, *middle)
                k3 = rates(y + 0.5 * h * k2, *middle)
                k4 = rates(y + h * k3, *end)
                y = states[k + 1] = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        states[0] = u[0, 4]
        T_w, T_h = np.moveaxis(states, 1, 0)
        drive, w = u[:, 1], u[:, 2]
        R, k_t, i = self.terminals(T_w, T_h, drive, w)
        torque = k_t * i - self.tau_c * np.tanh(w / self.w_small)
        read = {TORQUE: torque, WINDING: T_w, HOUSING: T_h, COLUMNS["voltage"]: R * i + k_t * w, COLUMNS["current"]: i}
        return [{n: v[: len(c.times), k] for n, v in read.items()} for k, c in enumerate(self.columns)]
