"""Figure of a walk: one stride above, temperatures over the whole walk below."""

import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from clients.walking import KELVIN, STEP

# Okabe and Ito's colours, distinguishable for colour-blind readers.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#666666"
CURVES = (RED, BLUE, GREEN, ORANGE)
STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "axes.axisbelow": True,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "legend.handlelength": 1.1,
    "legend.borderaxespad": 0.0,
    "svg.hashsalt": "motor-fmu",  # the same run gives the same bytes
    "svg.fonttype": "path",
}
POINTS = 1500  # per curve of the long panel; more is not visible
WIDTH = 5.4  # in; in a column of 390 px text of 9 pt is still 9 px high
BELOW = {"loc": "upper left", "bbox_to_anchor": (0.0, -0.28), "ncols": 2}  # a legend below a panel of this width hides no curve


def words(name: str) -> str:
    """A variable of a component in words."""
    component, _, own = name.rpartition(".")
    return own.replace("_", " ").capitalize() + (f", {component}" if component else "")


def wrapped(title: str) -> str:
    """A title in lines that fit the width."""
    return "\n".join(line for part in title.splitlines() for line in textwrap.wrap(part, 62))


def write(runs: dict, title: str, stem):
    """Writes `stem`.svg and `stem`.png from walks by name."""
    with plt.rc_context(STYLE):
        canvas = plt.figure(figsize=(WIDTH, 7.6), layout="constrained")
        canvas.suptitle(wrapped(title), fontweight="bold", fontsize=STYLE["font.size"], x=0.02, ha="left")
        top, bottom = canvas.subfigures(2, 1, height_ratios=(1.55, 1.0))
        name, run = next(iter(runs.items()))
        _stride(top.subplots(3, 1, sharex=True), name, run)
        _temperatures(bottom.subplots(), runs)
        canvas.savefig(f"{stem}.svg", metadata={"Date": None})
        canvas.savefig(f"{stem}.png", dpi=110)
        plt.close(canvas)


def _stride(axes, name, run):
    """The last whole stride of a run: torque, current and voltage, power."""
    gait = run.actuator.gait
    end = int(run.time[-1] / gait.stride_time) * gait.stride_time
    rows = slice(int(round((end - gait.stride_time) / STEP)), int(round(end / STEP)))
    percent = 100.0 * (run.time[rows] - run.time[rows][0]) / gait.stride_time
    m = {name: values[rows] for name, values in run.motor.items()}
    torque, electric, power = axes

    torque.plot(percent, run.torque_demand[rows], color=GREY, lw=3.5, alpha=0.4, label="demanded")
    torque.plot(percent, run.joint_torque[rows], color=BLUE, label="delivered")
    torque.set(title="Joint torque", ylabel="N·m")
    torque.legend()

    electric.plot(percent, m["current"], color=RED, label="current, A")
    electric.plot(percent, m["terminal_voltage"], color=BLUE, label="voltage, V")
    electric.set(title="Motor terminals")
    electric.legend()

    power.plot(percent, m["current"] * m["terminal_voltage"], color=ORANGE, label="electrical")
    power.plot(percent, m["load_torque"] * m["shaft_speed"], color=GREEN, label="motor shaft")
    power.plot(percent, (run.joint_torque * run.joint_speed)[rows], color=BLUE, label="joint")
    power.set(title="Power", ylabel="W")
    power.legend()
    axes[-1].set(xlabel=f"% of the last stride, {name}", xlim=(0, 100))
    for panel in axes:
        panel.axhline(0.0, color=GREY, lw=0.6)


def _temperatures(panel, runs):
    """Winding and housing over the whole walk, and the winding's limit."""
    for color, (name, run) in zip(CURVES, runs.items()):
        stride = int(round(run.actuator.gait.stride_time / STEP))
        every = max(1, run.time.size // POINTS)
        minutes = run.time / 60.0
        winding, housing = (run.motor[f"{node}_temperature"] - KELVIN for node in ("winding", "housing"))
        mean = winding[: winding.size // stride * stride].reshape(-1, stride).mean(axis=1)
        panel.plot(minutes[stride // 2 :: stride][: mean.size], mean, color=color, lw=1.8, label=f"winding, {name}")
        panel.plot(minutes[::every], housing[::every], color=color, ls="--", lw=1.2, label=f"housing, {name}")
        if run.motor["winding_temperature"][-1] > run.winding_limit:
            at = minutes[-1]
            panel.plot([at], [run.winding_limit - KELVIN], "o", color=color, ms=6)
            panel.annotate(
                f"after {at:.1f} min",
                (at, run.winding_limit - KELVIN),
                xytext=(-8, 8),
                textcoords="offset points",
                ha="right",
                color=color,
            )
    limit = next(iter(runs.values())).winding_limit - KELVIN
    panel.axhline(limit, color=GREY, lw=1.2, ls=":")
    panel.annotate(
        f"winding limit {limit:.0f} °C",
        (0.0, limit),
        xycoords=("axes fraction", "data"),
        xytext=(4, 4),
        textcoords="offset points",
        color=GREY,
    )
    end = max(run.time[-1] for run in runs.values()) / 60.0
    panel.set(title="Temperatures (winding: mean of each stride)", xlabel="minutes of walking", ylabel="°C", xlim=(0, 1.01 * end))
    panel.legend(**BELOW)
    panel.margins(y=0.12)


def operating_ranges(motors: dict, path):
    """Operating ranges as catalogues draw them, a panel for each motor: speed-torque line, continuous torque, nominal point of the catalogue."""
    with plt.rc_context(STYLE):
        columns = 2
        rows = -(-len(motors) // columns)
        canvas, grid = plt.subplots(rows, columns, figsize=(WIDTH, 2.7 * rows), layout="constrained", squeeze=False)
        for panel in grid.flat[len(motors) :]:
            panel.set_visible(False)
        for panel, (name, m) in zip(grid.flat, motors.items()):
            torque, speed = ([p[key] for p in m["points"]] for key in ("torque_mNm", "speed_rpm"))
            widest = 1.25 * max(*torque, m["printed_mNm"], m["with_cold_magnets_mNm"])
            panel.fill_betweenx(speed, torque, color=BLUE, alpha=0.15, lw=0)
            panel.plot(torque, speed, color=BLUE, label="continuous, model with warm magnets")
            cold, cold_speed = ([p[key] for p in m["cold_points"]] for key in ("torque_mNm", "speed_rpm"))
            panel.plot(cold, cold_speed, color=BLUE, ls="--", lw=1.2, label="magnets at 25 °C")
            # The line leaves the panel before the stall torque.
            at = min(widest, m["stall_torque_mNm"])
            slope = m["no_load_speed_rpm"] / m["stall_torque_mNm"]
            panel.plot([0, at], [m["no_load_speed_rpm"], m["no_load_speed_rpm"] - slope * at], color=GREY, label="speed-torque line at nominal voltage")
            low, high = 0.9 * m["printed_mNm"], 1.1 * m["printed_mNm"]
            panel.plot([low, high], [m["nominal_speed_rpm"]] * 2, color=RED, lw=1.0)
            panel.plot([m["printed_mNm"]], [m["nominal_speed_rpm"]], "o", color=RED, ms=5, label="nominal point of the catalogue, ±10 %")
            panel.set(title=name, xlabel="torque in mN·m", ylabel="speed in rpm", xlim=(0, widest), ylim=(0, None))
        handles, labels = grid.flat[0].get_legend_handles_labels()
        legend = canvas.legend(handles, labels, loc="outside lower left")
        canvas.savefig(path, metadata={"Date": None})
        assert legend.get_window_extent().width < canvas.bbox.width, "the legend is wider than the figure"
        plt.close(canvas)
