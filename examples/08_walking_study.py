"""What does cooling buy under gait, and which transmission and spring give the highest continuous torque?

The thesis asked at standstill; here the motor drives a series elastic actuator on an ankle (`loads/walk.toml`). For each cooling
arrangement and each activity: time until the winding reaches its limit with the whole biological torque, and the continuous support, the
fraction of that torque that can be given continuously. Then transmission ratio and spring are swept on level ground and on stairs, so that
a design that is best in one activity and fails in another is found. Every sentence of the page follows from the results.

Run it after `cargo xtask demo`, with `motor-fmu` on the path; `--out FOLDER` also writes the page and its figure. Progress goes to
standard error.
"""

import argparse
import json
import sys
import textwrap
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from clients.paths import EXAMPLES
from clients.program import motor_fmu

LOAD = str(EXAMPLES / "loads" / "walk.toml")
ACTUATOR = tomllib.loads(Path(LOAD).read_text(encoding="utf-8"))["actuator"]
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
REFERENCE = "bare"
# Body masses and activities; the data source of each is what the program says of gait.activity.
LEVEL = "level walking"
ACTIVITIES = {
    LEVEL: {"gait.activity": "walk"},
    "level walking, 60 kg": {"gait.activity": "walk", "gait.body_mass": 60},
    "level walking, 75 kg + 10 kg": {"gait.activity": "walk", "gait.body_mass": 85},
    "level walking, 100 kg": {"gait.activity": "walk", "gait.body_mass": 100},
    "stairs up": {"gait.activity": "stairs_up"},
    "stairs down": {"gait.activity": "stairs_down"},
    "slow walking, children's gait": {"gait.activity": "child_walk_slow"},
    "fast walking, children's gait": {"gait.activity": "child_walk_fast"},
}
# Activities in which ratio and spring are swept; the other arrangements are swept on level ground alone.
DESIGNED_FOR = (LEVEL, "stairs up", "stairs down")
RATIO, SPRING = "transmission.ratio", "spring.stiffness"
GRID = (f"{RATIO}=150:450:5", f"{SPRING}=100:400:4")
HOURS = 4
LIMITS = {
    "winding_temperature": "winding temperature",
    "thermal_runaway": "thermal runaway",
    "torque_error": "limits of current and supply voltage",
    "support_maximum": "greatest value of gait.support",
}


class Progress:
    """Finished jobs, with the time since the start, on standard error."""

    def __init__(self, jobs: int):
        self.jobs, self.done, self.start = jobs, 0, time.monotonic()

    def __call__(self, what: str):
        self.done += 1
        print(f"[{self.done}/{self.jobs}] {time.monotonic() - self.start:.0f} s  {what}", file=sys.stderr, flush=True)


def options(*settings: dict) -> list[str]:
    together = {name: value for setting in settings for name, value in setting.items()}
    return [part for name, value in together.items() for part in ("--set", f"{name}={value}")]


def walked(arrangement: str, activity: str, design: dict) -> dict:
    """An activity with an arrangement: minutes to the limit (null where it is not reached), and the continuous support."""
    sets = options(ARRANGEMENTS[arrangement], ACTIVITIES[activity], design)
    found = json.loads(motor_fmu("steady", "--preset", PRESET, "--load", LOAD, "--hours", str(HOURS), *sets, "--json"))
    continuous = found["continuous"]
    return {
        "minutes_to_limit": found["time_to_limit"] and found["time_to_limit"] / 60.0,
        "continuous_support": continuous["support"] if continuous else 0.0,
        "continuous_torque_Nm": continuous["at"]["joint_torque_peak"] if continuous else 0.0,
        "limited_by": LIMITS[continuous["limited_by"]] if continuous else found["no_continuous_torque"],
        "mass_kg": found["mass"],
        "gait": found["gait"],
    }


def swept(arrangement: str, activity: str) -> dict:
    """Continuous support over ratio and stiffness; an infeasible design has its reason in place of a support."""
    vary = [part for grid in GRID for part in ("--vary", grid)]
    sets = options(ARRANGEMENTS[arrangement], ACTIVITIES[activity])
    objective = ("--objective", "continuous_support", "--json")
    found = json.loads(motor_fmu("sweep", "--preset", PRESET, "--load", LOAD, *sets, *vary, *objective))
    names = dict(zip(found["varied"], ("ratio", "stiffness_Nm_per_rad")))
    point = lambda p: dict(zip(names.values(), p["values"])) | {"support": p["objective"], "infeasible": p["failure"]}  # noqa: E731
    return {
        "best": point(found["best"]),
        "edges": [f"{names[edge['name']]} {edge['end']}" for edge in found["best_at_edge"]],
        "points": [point(p) for p in found["points"]],
    }


def place(point: dict) -> tuple:
    return point["ratio"], point["stiffness_Nm_per_rad"]


def settings(point: dict) -> dict:
    return dict(zip((RATIO, SPRING), place(point)))


def study() -> dict:
    sweeps = [(a, activity) for a in ARRANGEMENTS for activity in (DESIGNED_FOR if a in SHOWN else (LEVEL,))]
    jobs = [(a, activity) for a in ARRANGEMENTS for activity in (ACTIVITIES if a in SHOWN else (LEVEL,))]
    progress = Progress(len(jobs) + len(sweeps) + len(ARRANGEMENTS))

    def declared(job):
        answer = walked(*job, {})
        progress(", ".join(job))
        return answer

    with ThreadPoolExecutor(2) as pool:
        answers = dict(zip(jobs, pool.map(declared, jobs)))
    grids = {}
    for job in sweeps:
        grids[job] = swept(*job)
        progress(f"ratio and spring: {', '.join(job)}")
    designs = {}
    for arrangement in ARRANGEMENTS:
        level = grids[arrangement, LEVEL]
        designs[arrangement] = {
            "mass_kg": answers[arrangement, LEVEL]["mass_kg"],
            "declared": answers[arrangement, LEVEL]["continuous_support"],
            "best": level["best"] | walked(arrangement, LEVEL, settings(level["best"])),
            "edges": level["edges"],
            "points": level["points"],
        }
        progress(f"best design, {arrangement}")
    return {
        "activities": {a: {activity: answers[a, activity] for activity in ACTIVITIES} for a in SHOWN},
        "designs": designs,
        "across_activities": {a: across(a, grids) for a in SHOWN},
        "pareto_front": front(designs),
    }


def across(arrangement: str, grids: dict) -> dict:
    """Support in each activity of the designs that are best in one of them, and of the one whose least support is greatest."""
    supports: dict = {}
    for activity in DESIGNED_FOR:
        for point in grids[arrangement, activity]["points"]:
            supports.setdefault(place(point), {})[activity] = (point["support"] or 0.0, point["infeasible"])
    row = lambda key: {  # noqa: E731
        "ratio": key[0],
        "stiffness_Nm_per_rad": key[1],
        "support": {activity: supports[key][activity][0] for activity in DESIGNED_FOR},
        "infeasible": {activity: supports[key][activity][1] for activity in DESIGNED_FOR if supports[key][activity][1]},
    }
    least = lambda key: min(support for support, _ in supports[key].values())  # noqa: E731
    chosen = {f"best for {activity}": row(max(supports, key=lambda key: supports[key][activity][0])) for activity in DESIGNED_FOR}
    return chosen | {"best in the worst activity": row(max(supports, key=least))}


def front(designs: dict) -> list[str]:
    """The arrangements that no lighter one exceeds in continuous torque."""
    best, found = 0.0, []
    for name, design in sorted(designs.items(), key=lambda item: item[1]["mass_kg"]):
        if design["best"]["continuous_torque_Nm"] > best:
            best = design["best"]["continuous_torque_Nm"]
            found.append(name)
    return found


def figure(answer: dict, path: Path):
    """Continuous torque over mass: every design, the best of each arrangement, and the front."""
    from clients.figure import CURVES, GREY, STYLE, WIDTH, plt, wrapped

    with plt.rc_context(STYLE):
        canvas, panel = plt.subplots(figsize=(WIDTH, 6.2), layout="constrained")
        for color, (name, design) in zip((GREY, *CURVES), answer["designs"].items()):
            mass, best = 1000.0 * design["mass_kg"], design["best"]
            whole = best["continuous_torque_Nm"] / best["support"]
            torques = [whole * point["support"] for point in design["points"] if point["support"] is not None]
            panel.plot([mass] * len(torques), torques, "o", ms=3, alpha=0.7, color=color, mew=0)
            label = f"{name}: {best['ratio']:.0f} : 1, {best['stiffness_Nm_per_rad']:.0f} N·m/rad"
            panel.plot(mass, best["continuous_torque_Nm"], "o", ms=8, color=color, label=label)
        line = [answer["designs"][name] for name in answer["pareto_front"]]
        panel.plot([1000.0 * d["mass_kg"] for d in line], [d["best"]["continuous_torque_Nm"] for d in line], color=GREY, lw=1.0, zorder=0, label="Pareto front")
        panel.plot([], [], "o", ms=3, color=GREY, mew=0, label="other ratios and springs")
        panel.set(
            title=wrapped(f"Continuous torque at the ankle\n{answer['activities'][REFERENCE][LEVEL]['gait']}"),
            xlabel="mass of motor, fan and annulus in g",
            ylabel="peak joint torque of the stride in N·m",
            ylim=(0, None),
        )
        canvas.legend(title="Best ratio and spring on level ground", loc="outside lower left", alignment="left")
        canvas.savefig(path, metadata={"Date": None})
        plt.close(canvas)


def percent(support: float) -> str:
    return f"{100.0 * support:.0f} %"


def listed(parts) -> str:
    *first, last = parts
    return f"{', '.join(first)} and {last}" if first else last


def at(point: dict) -> str:
    return f"{point['ratio']:.0f} : 1 and {point['stiffness_Nm_per_rad']:.0f} N.m/rad"


def ended(cell: dict) -> str:
    return f"not within {HOURS} h" if cell["minutes_to_limit"] is None else f"after {cell['minutes_to_limit']:.0f} min"


def declared_design(answer: dict) -> str:
    """Level walking with the ratio and spring of `walk.toml`."""
    cells = {name: answer["activities"][name][LEVEL] for name in SHOWN}
    times = listed([f"{name} {ended(cell)}" for name, cell in cells.items()])
    supports = listed([f"{name} {percent(cell['continuous_support'])}" for name, cell in cells.items()])
    reference = cells[REFERENCE]
    gains = [
        f"{name} has {cell['continuous_torque_Nm'] / reference['continuous_torque_Nm']:.2f} times the continuous torque of {REFERENCE} with "
        f"{100.0 * (cell['mass_kg'] / reference['mass_kg'] - 1.0):.0f} % more mass"
        for name, cell in cells.items()
        if name != REFERENCE
    ]
    return f"""With the transmission ratio ({ACTUATOR[RATIO]:.0f} : 1) and spring stiffness ({ACTUATOR[SPRING]['value']:.0f} N.m/rad) of `walk.toml`
    and the whole biological torque of the ankle of a person of 75 kg, the winding reaches its temperature limit: {times}. The continuous
    support is the fraction of the biological torque that the actuator can deliver continuously: {supports}. The continuous torque is the
    peak torque of the joint at the continuous support. Effect of cooling: {listed(gains)}."""


def grid_words() -> str:
    """The values of the grid."""
    (ratio, spring) = ([float(x) for x in part.split("=")[1].split(":")] for part in GRID)
    return f"{ratio[2]:.0f} ratios from {ratio[0]:.0f} to {ratio[1]:.0f}, {spring[2]:.0f} stiffnesses from {spring[0]:.0f} to {spring[1]:.0f} N.m/rad"


def best_designs(answer: dict) -> str:
    """The best ratio and spring of each arrangement, with the gain against those of `walk.toml`, and edges of the grid."""
    designs = answer["designs"]
    gain = lambda d: f"{100.0 * (d['best']['support'] / d['declared'] - 1.0):+.0f} %"  # noqa: E731
    best = [f"{name} {d['best']['continuous_torque_Nm']:.0f} N.m at {at(d['best'])} ({gain(d)})" for name, d in designs.items()]
    text = f"""Transmission ratio and spring stiffness were varied over a grid ({grid_words()}). Continuous torque on level ground with the best
    ratio and stiffness of the grid, and its change relative to those of `walk.toml` in the same arrangement:
    {"; ".join(best)}."""
    edges: dict = {}
    for name, design in designs.items():
        for edge in design["edges"]:
            edges.setdefault(edge, []).append(name)
    for edge, names in edges.items():
        variable, end = edge.split()
        text += f" The best {variable.split('_')[0]} is at the {end} end of the grid for {listed(names)}: the optimum may lie outside."
    bends = {name: d["best"]["continuous_torque_Nm"] / d["best"]["stiffness_Nm_per_rad"] for name, d in designs.items()}
    low, high = min(bends.values()), max(bends.values())
    text += f" With the best stiffness the springs deflect by {low:.2f} to {high:.2f} rad at the peak torque."
    infeasible = {name: [p for p in d["points"] if p["infeasible"]] for name, d in designs.items()}
    counts = [f"{name} {len(points)} of {len(designs[name]['points'])}" for name, points in infeasible.items() if points]
    text += f" Designs without a continuous support on level ground (infeasible): {listed(counts)}." if counts else " Every design of the grid has a continuous support on level ground."
    return text


def robust_designs(answer: dict) -> str:
    """What the design that is best on level ground does on stairs, and the design with the best worst activity."""
    sentences = []
    for name, rows in answer["across_activities"].items():
        level, robust = rows[f"best for {LEVEL}"], rows["best in the worst activity"]
        declared = {activity: answer["activities"][name][activity]["continuous_support"] for activity in DESIGNED_FOR}
        worse = [
            f"{activity} {percent(level['support'][activity])} instead of {percent(declared[activity])}"
            + (f" (infeasible: {level['infeasible'][activity]})" if activity in level["infeasible"] else "")
            for activity in DESIGNED_FOR
            if level["support"][activity] < declared[activity]
        ]
        first = f"{name[0].upper()}{name[1:]}: the best design on level ground, {at(level)},"
        verdict = f"gives less support than the design of `walk.toml`: {listed(worse)}" if worse else "gives at least the support of the design of `walk.toml` in every activity"
        sentences.append(f"{first} {verdict}.")
        supports = listed([f"{activity} {percent(robust['support'][activity])}" for activity in DESIGNED_FOR])
        sentences.append(f"The design with the greatest support in its worst activity has {at(robust)}: {supports}.")
    return " ".join(sentences)


def front_sentence(answer: dict) -> str:
    members = answer["pareto_front"]
    others = [name for name in answer["designs"] if name not in members]
    text = f"These arrangements are on the Pareto front of continuous torque over mass: {listed(members)}."
    torque = lambda name: answer["designs"][name]["best"]["continuous_torque_Nm"]  # noqa: E731
    mass = lambda name: answer["designs"][name]["mass_kg"]  # noqa: E731

    def better(name: str) -> str:
        """The arrangement of the front with the largest torque among those that are not heavier."""
        return max((one for one in members if mass(one) <= mass(name)), key=torque)

    def instead(name: str) -> str:
        relation = "is lighter" if mass(better(name)) < mass(name) else "has the same mass"
        return f"{name} ({torque(name):.0f} N.m; {better(name)}, which {relation}: {torque(better(name)):.0f} N.m)"

    worse = [instead(name) for name in others]
    return text + (f" Not on it: {listed(worse)}." if worse else "")


def markdown(answer: dict) -> str:
    """The page. Every number and every conclusion is of `answer`."""
    table = answer["activities"]
    gait = table[REFERENCE][LEVEL]["gait"]
    paragraphs = [
        """This page is generated by `examples/08_walking_study.py`; the nightly tests run the example and compare the page. A motor drives an ankle
        through a transmission and a series spring. Arrangements: bare motor; fan 5 mm from the motor in crossflow; fan that pushes air
        through an annulus with an outer diameter of 40, 37.5 or 35 mm.""",
        f"""Motor: preset `{PRESET}`; actuator and load: `examples/loads/walk.toml`. Gait data: {gait[0].lower()}{gait[1:]}.
        The stride time was not published with these data; `fmu-src/physics/data/gait-walking-stairs-cc0/SOURCE.md` states its source.""",
        declared_design(answer),
        best_designs(answer),
        robust_designs(answer),
        front_sentence(answer),
    ]
    fill = lambda paragraph: textwrap.fill(" ".join(paragraph.split()), 128, break_on_hyphens=False)  # noqa: E731
    text = "# Continuous torque with fan and annulus in walking\n\n" + "\n\n".join(map(fill, paragraphs)) + "\n"
    text += "\n## Activities with the ratio and stiffness of `walk.toml`\n"
    text += "\n| activity | " + " | ".join(SHOWN) + " | gait data |\n" + "|---" * (2 + len(SHOWN)) + "|\n"
    for activity in ACTIVITIES:
        cells = []
        for arrangement in SHOWN:
            cell = table[arrangement][activity]
            end = f"> {HOURS} h" if cell["minutes_to_limit"] is None else f"{cell['minutes_to_limit']:.0f} min"
            cells.append(f"{end}; {percent(cell['continuous_support'])}, {cell['limited_by']}")
        text += f"| {activity} | {' | '.join(cells)} | {table[REFERENCE][activity]['gait']} |\n"
    text += "\nEach cell contains the time to the winding's limit with the whole biological torque, then the continuous support (with an rms\n"
    text += "torque error of at most 0.5 N.m + 5 % of the peak torque) and the quantity that limits it. If not stated, the body mass is 75 kg.\n"
    text += "75 kg + 10 kg: the person has a load of 10 kg (`gait.body_mass` = 85).\n"
    text += "\n## Continuous support of designs in three activities\n"
    text += "\n| arrangement | design | ratio | spring N.m/rad | " + " | ".join(DESIGNED_FOR) + " |\n" + "|---" * (4 + len(DESIGNED_FOR)) + "|\n"
    for arrangement, rows in answer["across_activities"].items():
        for name, row in rows.items():
            cells = ["infeasible" if activity in row["infeasible"] else percent(row["support"][activity]) for activity in DESIGNED_FOR]
            text += f"| {arrangement} | {name} | {row['ratio']:.0f} | {row['stiffness_Nm_per_rad']:.0f} | {' | '.join(cells)} |\n"
    text += "\nThe columns of the activities contain the continuous support.\n"
    text += f"\n![Continuous torque over mass]({FIGURE})\n"
    text += "\n| arrangement | mass g | best ratio | best spring N.m/rad | continuous torque N.m | at the edge of the grid |\n|---|---|---|---|---|---|\n"
    for name, design in answer["designs"].items():
        b = design["best"]
        edges = ", ".join(edge.replace("stiffness_Nm_per_rad", "spring") for edge in design["edges"]) or "no"
        text += f"| {name} | {1000 * design['mass_kg']:.0f} | {b['ratio']:.0f} | {b['stiffness_Nm_per_rad']:.0f} | {b['continuous_torque_Nm']:.1f} | {edges} |\n"
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
