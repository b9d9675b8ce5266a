"""A powered ankle walks until the winding of its motor reaches the limit, at most 20 min, without and with fan.

The actuator gives the whole biological torque of the ankle in level walking. The motor FMU has the start values of preset maxon-305015. It
is driven by its current: the current loop of a real drive settles within a tenth of the 1 ms step used here, and the actuator keeps the
command within what the supply voltage allows. `--drive voltage` puts the voltage on the terminals instead.

Writes walking.svg, walking.png and walking.json to --out, and prints the results with the figure's caption.
"""

import argparse
import json
from pathlib import Path

from clients import figure
from clients.actuator import Design
from clients.gait import ACTIVITIES, JOINTS, Gait
from clients.paths import archive, dist
from clients.walking import KELVIN, results, walk

# Friction of the datasheet's no-load current: the declared motor has none.
PRESET = "maxon-305015"
COOLING = {"still air": 0.0, "fan at full speed": 1.0}


def command_line():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, help=f"archive to use (default: the FMI 2.0 one of preset {PRESET})")
    parser.add_argument("--out", type=Path, default=dist(), help="folder for the figure and the results")
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--body-mass", type=float, default=75.0, help="kg")
    parser.add_argument("--activity", default="walk", help=", ".join(ACTIVITIES))
    parser.add_argument("--joint", default="ankle", help=", ".join(JOINTS))
    parser.add_argument("--support", type=float, default=1.0, help="fraction of the biological torque")
    parser.add_argument("--ratio", type=float, default=Design.ratio)
    parser.add_argument("--stiffness", type=float, default=Design.stiffness, help="N.m/rad at the joint")
    parser.add_argument("--drive", choices=("current", "voltage"), default="current")
    return parser


def caption(options, gait, report, limit) -> str:
    """The figure's caption, from the results."""
    motor = str(options.fmu or f"preset {PRESET}")
    sentences = [
        f"The motor ({motor}) gives {options.support:.0%} of the biological torque of the {options.joint}, body mass {options.body_mass:g} kg.",
        f"Gait: {gait.source}.",
    ]
    for name, found in report.items():
        if found["winding_limit_reached"]:
            end = f"the winding reaches its limit of {limit:.0f} °C after {found['minutes_walked']:.1f} min"
        else:
            end = f"the winding is at {found['winding_temperature_peak_degC']:.0f} °C at most in {found['minutes_walked']:.0f} min (limit {limit:.0f} °C)"
        sentences.append(f"{name[0].upper()}{name[1:]}: {end}.")
    return " ".join(sentences)


def main(options):
    gait = Gait(options.body_mass, options.activity, options.joint, options.support)
    design = Design(ratio=options.ratio, stiffness=options.stiffness)
    path = options.fmu or archive("AnnulusCooledMotor", fmi=2, preset=PRESET)
    seconds = 60.0 * options.minutes
    runs = {name: walk(path, gait, design, seconds, options.drive, fan, label=name) for name, fan in COOLING.items()}
    report = {name: results(run) for name, run in runs.items()}
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "walking.json").write_text(json.dumps(report, indent=2) + "\n")
    title = f"Powered {options.joint}, {options.body_mass:g} kg, {options.support:.0%} support, {PRESET if options.fmu is None else options.fmu.name}"
    figure.write(runs, f"{title}\n{gait.source}", options.out / "walking")
    limit = next(iter(runs.values())).winding_limit - KELVIN
    print(json.dumps(report | {"caption": caption(options, gait, report, limit)}, indent=2, ensure_ascii=False))


if __name__ == "__main__":
    parser = command_line()
    try:
        main(parser.parse_args())
    except (ValueError, FileNotFoundError) as error:
        parser.error(str(error))
