"""What does cooling buy under gait, and which transmission and spring make the most of it?

The thesis asked at standstill; here the motor walks, in a series elastic actuator on an ankle (`loads/walk.toml`). For each arrangement
of cooling: how long a person can walk, climb stairs or carry 10 kg before the winding reaches its limit, and what share of a healthy
ankle's torque the motor can give for ever. Then transmission ratio, spring and annulus are swept, and the continuous torque stands
against the mass. Run it after `cargo xtask demo`, with `motor-fmu` on the path; `--out FOLDER` also writes the page and its figure.
"""

import argparse
import csv
import json
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

from clients.paths import EXAMPLES
from clients.program import motor_fmu

LOAD = str(EXAMPLES / "loads" / "walk.toml")
PRESET = "thesis-rig"
FIGURE = "walking-study.svg"
# Outer diameter, m, and mass, kg, of the thesis's two annuli, and one half way between.
ANNULI = {"40 mm": (0.040, 0.0155), "37.5 mm": (0.0375, 0.01675), "35 mm": (0.035, 0.0180)}
ARRANGEMENTS = {
    "bare": {"cooling_mode": "bare"},
    "fan at 5 mm": {"cooling_mode": "fan_crossflow", "fan_command": 1.0},
} | {
    f"{name} annulus": {
        "cooling_mode": "annulus_push",
        "fan_command": 1.0,
        "annulus.outer_diameter": diameter,
        "annulus.mass": mass,
    }
    for name, (diameter, mass) in ANNULI.items()
}
SHOWN = ("bare", "fan at 5 mm", "40 mm annulus")
ACTIVITIES = {
    "walking": {"gait.activity": "walk"},
    "walking fast": {"gait.activity": "walk_fast"},
    "walking with 10 kg": {"gait.activity": "walk", "gait.body_mass": 85},
    "stairs up": {"gait.activity": "stairs_up"},
    "stairs down": {"gait.activity": "stairs_down"},
}
GRID = ("transmission.ratio=150:450:5", "spring.stiffness=100:400:4")
HOURS = 4


def options(*settings: dict) -> list[str]:
    together = {name: value for setting in settings for name, value in setting.items()}
    return [part for name, value in together.items() for part in ("--set", f"{name}={value}")]


def walked(job) -> dict:
    """An activity with an arrangement: minutes to the limit (null where it is not reached), and what can be given for ever."""
    arrangement, activity = job
    sets = options(ARRANGEMENTS[arrangement], ACTIVITIES[activity])
    found = json.loads(motor_fmu("steady", "--preset", PRESET, "--load", LOAD, "--hours", str(HOURS), *sets, "--json"))
    continuous = found["continuous"]
    return {
        "minutes_to_limit": found["time_to_limit"] and found["time_to_limit"] / 60.0,
        "support_for_ever": continuous["support"],
        "torque_for_ever_Nm": continuous["at"]["joint_torque_peak"],
        "mass_kg": found["mass"],
    }


def swept(arrangement: str) -> list[dict]:
    """Continuous torque over ratio and stiffness; designs that cannot follow the gait at all are left out."""
    with TemporaryDirectory() as folder:
        table = Path(folder) / "sweep.csv"
        vary = [part for grid in GRID for part in ("--vary", grid)]
        sets = options(ARRANGEMENTS[arrangement])
        motor_fmu("sweep", "--preset", PRESET, "--load", LOAD, *sets, *vary, "--output", str(table), "--json")
        with table.open(newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["continuous_torque"]]
    names = {"transmission.ratio": "ratio", "spring.stiffness": "stiffness_Nm_per_rad", "continuous_torque": "torque_Nm"}
    return [{short: float(row[name]) for name, short in names.items()} for row in rows]


def study() -> dict:
    jobs = [(arrangement, activity) for arrangement in SHOWN for activity in ACTIVITIES]
    with ThreadPoolExecutor(2) as pool:
        answers = dict(zip(jobs, pool.map(walked, jobs)))
    table = {a: {activity: answers[a, activity] for activity in ACTIVITIES} for a in SHOWN}
    designs = {}
    for arrangement in ARRANGEMENTS:
        points = swept(arrangement)
        best = max(points, key=lambda point: point["torque_Nm"])
        declared = walked((arrangement, "walking")) if arrangement not in SHOWN else table[arrangement]["walking"]
        designs[arrangement] = {"mass_kg": declared["mass_kg"], "best": best, "points": points}
    lightest_first = sorted(designs.items(), key=lambda item: item[1]["mass_kg"])
    best_so_far, front = 0.0, []
    for name, design in lightest_first:
        if design["best"]["torque_Nm"] > best_so_far:
            best_so_far = design["best"]["torque_Nm"]
            front.append(name)
    return {"activities": table, "designs": designs, "pareto_front": front}


def figure(answer: dict, path: Path):
    """Continuous torque over mass: every design, the best of each arrangement, and the front."""
    from clients.figure import CURVES, GREY, STYLE, plt

    with plt.rc_context(STYLE):
        canvas, panel = plt.subplots(figsize=(8.0, 4.6), layout="constrained")
        for color, (name, design) in zip((GREY, *CURVES), answer["designs"].items()):
            mass = 1000.0 * design["mass_kg"]
            torques = [point["torque_Nm"] for point in design["points"]]
            panel.plot([mass] * len(torques), torques, "o", ms=3, alpha=0.35, color=color, mew=0)
            best = design["best"]
            panel.plot(mass, best["torque_Nm"], "o", ms=8, color=color, label=f"{name}: {best['ratio']:.0f} : 1, {best['stiffness_Nm_per_rad']:.0f} N·m/rad")
        front = [answer["designs"][name] for name in answer["pareto_front"]]
        panel.plot([1000.0 * d["mass_kg"] for d in front], [d["best"]["torque_Nm"] for d in front], color=GREY, lw=1.0, zorder=0)
        panel.set(
            title="Torque at the ankle that can be walked for ever",
            xlabel="motor, fan and annulus, g",
            ylabel="greatest joint torque of the stride, N·m",
            ylim=(0, None),
        )
        panel.legend(title="best ratio and spring", loc="lower right")
        canvas.savefig(path, metadata={"Date": None})
        plt.close(canvas)


def markdown(answer: dict) -> str:
    """The answer with its numbers."""
    table, designs = answer["activities"], answer["designs"]
    bare, fan, annulus = (table[name]["walking"] for name in SHOWN)
    best = {name: design["best"]["torque_Nm"] for name, design in designs.items()}
    better = lambda name: f"{100 * (best[name] / table[name]['walking']['torque_for_ever_Nm'] - 1):+.0f} %"  # noqa: E731
    minutes = lambda cell: "for ever" if cell["minutes_to_limit"] is None else f"{cell['minutes_to_limit']:.0f} min"  # noqa: E731
    paragraphs = [
        "Made by `examples/08_walking_study.py`; the tests run it and compare this page.",
        f"""A person of 75 kg walks on a powered ankle that gives all of a healthy ankle's torque: the thesis's motor behind 250 : 1 and a
        spring of 250 N.m/rad. Bare, the winding reaches 155 °C after {minutes(bare)}; with the fan after {minutes(fan)}, with the
        40 mm annulus after {minutes(annulus)}. For ever the bare motor can give {100 * bare["support_for_ever"]:.0f} % of the torque, with
        the fan {100 * fan["support_for_ever"]:.0f} %, with the annulus {100 * annulus["support_for_ever"]:.0f} %.""",
        f"""So under gait cooling buys {fan["torque_for_ever_Nm"] / bare["torque_for_ever_Nm"]:.2f} times the torque for
        {100 * (fan["mass_kg"] / bare["mass_kg"] - 1):.0f} % more mass of motor and fan. Transmission and spring buy more for no mass at
        all: with ratio and spring chosen for each arrangement the bare motor gives {best["bare"]:.0f} N.m for ever
        ({better("bare")}), the one with the fan {best["fan at 5 mm"]:.0f} N.m ({better("fan at 5 mm")}), the one with the 40 mm annulus
        {best["40 mm annulus"]:.0f} N.m ({better("40 mm annulus")}). On the front of torque over mass lie: {", ".join(answer["pareto_front"])}.
        On this rig, whose annulus leaks, the fan alone stays the better buy under gait, too. The softest spring of the grid is the
        best: it stores most of what the ankle gives back, as a tendon does. Softer ones would bend by more than a radian.""",
    ]
    fill = lambda paragraph: textwrap.fill(" ".join(paragraph.split()), 128)  # noqa: E731
    text = "# What cooling buys under gait\n\n" + "\n\n".join(map(fill, paragraphs)) + "\n"
    text += "\n| activity | " + " | ".join(SHOWN) + " |\n" + "|---" * (1 + len(SHOWN)) + "|\n"
    for activity in ACTIVITIES:
        cells = [f"{minutes(table[a][activity])}, {100 * table[a][activity]['support_for_ever']:.0f} %" for a in SHOWN]
        text += f"| {activity} | " + " | ".join(cells) + " |\n"
    text += "\nTime to the limit with all of the torque, and the share of it that can be given for ever (and followed to 5 %). On stairs\n"
    text += "torque and speed share a measured power by an estimate (`fmu-src/physics/src/components/gait/tables.rs`).\n"
    text += f"\n![Continuous torque over mass]({FIGURE})\n"
    text += "\n| arrangement | mass g | best ratio | best spring N.m/rad | torque for ever N.m |\n|---|---|---|---|---|\n"
    for name, design in designs.items():
        b = design["best"]
        text += f"| {name} | {1000 * design['mass_kg']:.0f} | {b['ratio']:.0f} | {b['stiffness_Nm_per_rad']:.0f} | {b['torque_Nm']:.1f} |\n"
    return text


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help=f"folder to write walking-study.md, its numbers and {FIGURE} to")
    out = parser.parse_args().out
    answer = study()
    if out:
        (out / "walking-study.md").write_text(markdown(answer), encoding="utf-8")
        (out / "walking-study.json").write_text(json.dumps(answer), encoding="utf-8")
        figure(answer, out / FIGURE)
    print(json.dumps(answer, indent=2))
