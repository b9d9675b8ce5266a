"""The shift between two clocks: that of the logged power and that of the thermometer which the power warms.

While the winding has warmed by only a few kelvin, its heat loss is negligible and its reading is

    T(t) = T_0 + a E_tau(t - s),    E_tau + tau dE_tau/dt = E,    E the energy since the power's log began             (1)

with s the shift, tau the lag of the reading (the thermocouple, and the way of the heat to it) and a a scale. The onset of the
rise alone would give s + tau; the curvature at its foot distinguishes the two. T_0 and a follow by linear regression for every
s and tau, which are taken from successively refined grids. Eq. (1) is fitted up to several rises; the result is the median, and
the spread of the fits is its uncertainty.
"""

from dataclasses import dataclass

import numpy as np

RISES_K = (4.0, 6.0, 8.0, 10.0, 12.0)
# Foot of the rise: the reading stays this far above its initial value, K.
FOOT_K = 1.0
# Grids of shift (around the foot) and lag, s; then this many times finer around the best.
SHIFTS_S = np.arange(-10.0, 2.0, 0.25)
LAGS_S = np.geomspace(0.1, 10.0, 25)
REFINEMENTS = 5
FINE_S = 0.05


@dataclass(frozen=True)
class Alignment:
    """Clock of the temperatures = clock of the power + shift."""

    shift_s: float
    sure_to_s: float
    lag_s: float
    rms_K: float


def align(time: np.ndarray, winding: np.ndarray, power_time: np.ndarray, power: np.ndarray) -> Alignment:
    """The shift of a run; the winding must be measured from before the rise until it has warmed by the largest of `RISES_K`."""
    there = np.isfinite(winding)
    time, winding = time[there], winding[there]
    rise = winding - np.median(winding[:10])
    if not np.any(rise > RISES_K[-1]):
        raise ValueError(f"the winding never warms by {RISES_K[-1]:g} K; {np.max(rise, initial=0.0):.1f} K is the most")
    foot = time[np.argmax(rise > FOOT_K)]
    found = []
    for warm in RISES_K:
        rows = slice(0, int(np.argmax(rise > warm)))
        found.append(_fit(time[rows], winding[rows], power_time, power, foot))
    shifts, lags, rms = np.array(found).T
    return Alignment(float(np.median(shifts)), float(np.ptp(shifts) / 2.0), float(np.median(lags)), float(np.median(rms)))


def _fit(time, winding, power_time, power, foot):
    """Shift, lag and what is left of eq. (1) over these rows."""
    shifts, lags = foot + SHIFTS_S, LAGS_S
    for _ in range(REFINEMENTS):
        left = np.array([_left(time, winding, power_time, power, shifts, lag) for lag in lags])
        i, j = np.unravel_index(np.argmin(left), left.shape)
        best = shifts[j], lags[i], left[i, j]
        step, ratio = shifts[1] - shifts[0], lags[1] / lags[0]
        shifts = best[0] + step * np.linspace(-2.0, 2.0, 17)
        lags = best[1] * ratio ** np.linspace(-2.0, 2.0, 17)
    return best


def _left(time, winding, power_time, power, shifts, lag):
    """Root of the mean square that eq. (1) leaves, for every shift."""
    fine, energy = _lagged_energy(power_time, power, lag, time[-1] - shifts.min())
    warmed = np.interp(time[None, :] - shifts[:, None], fine, energy)
    x = warmed - warmed.mean(axis=1, keepdims=True)
    y = winding - winding.mean()
    xx = np.sum(x * x, axis=1)
    explained = np.where(xx > 0.0, (x @ y) ** 2 / np.where(xx > 0.0, xx, 1.0), 0.0)
    return np.sqrt(np.maximum(y @ y - explained, 0.0) / len(y))


def _lagged_energy(power_time, power, lag, end):
    """E_tau of eq. (1) at fine steps from the log's first row on; 0 before it."""
    fine = power_time[0] + FINE_S * np.arange(int(max(end - power_time[0], 1.0) / FINE_S) + 2)
    # A row's power holds until the next row.
    rows = np.searchsorted(power_time, fine + 1e-9, side="right") - 1
    energy = np.concatenate([[0.0], np.cumsum(power[rows[:-1]]) * FINE_S])
    # A first-order lag is a convolution with exp(-t/tau)/tau; the weights sum to 1 over each fine step.
    weights = np.exp(-np.arange(len(fine)) * FINE_S / lag) * (1.0 - np.exp(-FINE_S / lag))
    lagged = np.convolve(0.5 * (energy + np.concatenate([[0.0], energy[:-1]])), weights)[: len(fine)]
    return fine, lagged
