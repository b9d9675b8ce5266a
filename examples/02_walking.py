"""A powered ankle walks for twenty minutes: how warm does its motor get, and what does a fan buy?

The actuator gives the whole torque of a healthy ankle at the walker's own speed, and stops at the winding's limit. The motor FMU is driven by its
current: the current loop of a real drive settles within a tenth of the 1 ms step used here, and the actuator keeps
the command within what the supply's voltage can push. `--drive voltage` puts the voltage on the terminals instead.

Writes walking.svg, walking.png and walking.json to --out.
"""

import argparse
import json
from pathlib import Path

from clients import figure
from clients.actuator import Design
from clients.gait import JOINTS, Gait, stride_times
from clients.paths import archive, dist
from clients.walking import results, walk

# Friction of the datasheet's no-load current: the declared motor has none.
PRESET = "maxon-305015"
COOLING = {"still air": 0.0, "fan at full speed": 1.0}


def command_line():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, help="archive to use (default: the FMI 2.0 one of preset maxon-305015)")
    parser.add_argument("--out", type=Path, default=dist(), help="folder for the figure and the results")
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--body-mass", type=float, default=75.0, help="kg")
    parser.add_argument("--speed", default="Free", help=", ".join(stride_times()))
    parser.add_argument("--joint", default="ankle", help=", ".join(JOINTS))
    parser.add_argument("--support", type=float, default=1.0, help="share of the biological torque")
    parser.add_argument("--ratio", type=float, default=Design.ratio)
    parser.add_argument("--stiffness", type=float, default=Design.stiffness, help="N.m/rad at the joint")
    parser.add_argument("--drive", choices=("current", "voltage"), default="current")
    return parser


def main(options):
    gait = Gait(options.body_mass, options.speed, options.joint, options.support)
    design = Design(ratio=options.ratio, stiffness=options.stiffness)
    path = options.fmu or archive("AnnulusCooledMotor", fmi=2, preset=PRESET)
    seconds = 60.0 * options.minutes
    runs = {name: walk(path, gait, design, seconds, options.drive, fan, label=name) for name, fan in COOLING.items()}
    report = {name: results(run) for name, run in runs.items()}
    options.out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(report, indent=2)
    (options.out / "walking.json").write_text(text + "\n")
    title = f"Powered {options.joint}, {options.body_mass:g} kg, {options.speed.lower()} speed, {options.support:.0%} support"
    figure.write(runs, title, options.out / "walking")
    print(text)


if __name__ == "__main__":
    parser = command_line()
    try:
        main(parser.parse_args())
    except (ValueError, FileNotFoundError) as error:
        parser.error(str(error))
