"""The files of a set: `experiment.toml`, `run-k.csv`, `truth.json`."""

import json
from pathlib import Path

import numpy as np
from bench.rig import AMBIENT, COLUMNS, FAN, HOUSING, SPEED, TORQUE, WINDING
from bench.write import file_name, toml_table

from .draw import Set

DIGITS = 6
# Column: header, quantity and unit of a foreign file, and its values from ours.
FOREIGN = {
    "time_s": ("t [min]", "time", "min", lambda v: v / 60.0),
    COLUMNS["current"]: ("I_mot [mA]", "current", "mA", lambda v: v * 1e3),
    COLUMNS["voltage"]: ("U [mV]", "voltage", "mV", lambda v: v * 1e3),
    COLUMNS["power"]: ("P_el", "electrical_power", "W", lambda v: v),
    SPEED: ("n [rpm]", "speed", "rpm", lambda v: v * 60.0 / (2.0 * np.pi)),
    TORQUE: ("M [mNm]", "shaft_torque", "mN.m", lambda v: v * 1e3),
    FAN: ("Fan [%]", "fan_command", "%", lambda v: v * 100.0),
    AMBIENT: ("T_amb [K]", "ambient_temperature", "K", lambda v: v + 273.15),
    WINDING: ("T_W [°F]", "winding_temperature", "degF", lambda v: 1.8 * v + 32.0),
    HOUSING: ("T_G [K]", "housing_temperature", "K", lambda v: v + 273.15),
}


def experiment(s: Set) -> str:
    head = {"name": s.name, "model": "AnnulusCooledMotor", "preset": "maxon-305015"}
    head |= {"inputs": list(s.rig.layout.inputs), "outputs": list(s.rig.layout.outputs)}
    tables = [
        toml_table("[experiment]", head),
        toml_table("[set]", {"cooling_mode": "conductance", "commutation": "equivalent_dc"} | s.rig.nominal),
    ]
    if not s.facts.get("no_prior"):
        tables.append(toml_table("[prior]", s.prior))
    if s.stated:
        tables.append(toml_table("[noise]", s.bench.noise))
    if s.facts.get("foreign"):
        columns = ["time_s", *s.rig.layout.inputs, *s.rig.layout.outputs]
        lines = [
            f'{json.dumps(h, ensure_ascii=False)} = {{ name = "{q}", unit = "{u}" }}'
            for h, q, u, _ in (FOREIGN[c] for c in columns)
        ]
        tables.append("\n".join(["[columns]", *lines]) + "\n")
    for k, run in enumerate(s.runs):
        tables.append(
            toml_table(
                "[[run]]", {"file": file_name(k), "role": run.role} | ({"start": "measured"} if run.warm else {})
            )
        )
    return "# Synthetic. See truth.json beside this set.\n" + "\n".join(tables)


def csv(s: Set, k: int) -> str:
    run, facts = s.runs[k], s.facts
    columns = {"time_s": run.times[run.kept] * facts.get("time_factor", 1.0)} | run.readings
    columns.pop(facts.get("missing"), None)
    headers, cell, between = list(columns), lambda v: f"{v:.{DIGITS}g}", ","
    if facts.get("foreign"):
        columns = {FOREIGN[c][0]: FOREIGN[c][3](v) for c, v in columns.items()}
        headers = list(columns)
        if facts["foreign"] == "semicolon":
            cell, between = (lambda v: f"{v:.{DIGITS}g}".replace(".", ",")), ";"
    first = (lambda v: f"{v:.10g}".replace(".", ",")) if between == ";" else (lambda v: f"{v:.10g}")
    lines = [between.join(headers)]
    rng = np.random.default_rng(k)
    for row, (t, *values) in enumerate(zip(*columns.values())):
        cells = [first(t), *(cell(v) for v in values)]
        if k == 0 and facts.get("text") and row == 40:
            cells[-1] = facts["text"]
        lines.append(between.join(cells))
        if rng.random() < facts.get("repeat", 0.0):
            lines.append(lines[-1])
    return "\n".join(lines) + "\n"


def law_facts(s: Set, law) -> dict:
    facts = {
        "id": law.id,
        "port": law.port,
        "driver": law.drivers[0],
        "drivers": list(law.drivers),
        "parameters": law.parameters | law.fixed,
    }
    facts["runs"] = [file_name(k) for k in range(len(s.runs)) if law.acts_in(k)]
    return facts | ({"lag_s": law.lag} if law.lag is not None else {})


def truth(s: Set) -> dict:
    """The content of `truth.json`."""
    found = {
        "effects": [law_facts(s, law) for law in s.laws if law.listed],
        "law": next((law_facts(s, law) for law in s.laws if not law.listed), None),
    }
    kept = (
        "structure_error",
        "structure_error_test",
        "structure_error_max",
        "pieces",
        "scale",
        "true_of_structure",
        "wrong_prior",
    )
    kept += ("effective_parameters", "signal", "detectable", "drivers", "ports")
    return {
        "name": s.name,
        "kind": s.kind,
        "motor": s.rig.nominal,
        "drive": s.rig.layout.drive,
        **found,
        "mistake": s.mistake,
        "parameters": {n: s.specimen[n] for n in s.prior},
        "noise": s.bench.noise,
        "warm": any(run.warm for run in s.runs),
        "floor": s.floor,
        **{key: s.facts[key] for key in kept if key in s.facts},
        "correct": correct(s),
    }


def correct(s: Set) -> str:
    """One sentence: what a correct report says."""
    if s.mistake and "works" not in s.mistake["answers"]:
        channels = ", ".join(filter(None, s.mistake["channels"])) or "the experiment"
        return f"{' or '.join(s.mistake['answers'])}: {channels}; nothing is named"
    if not s.laws:
        return "nothing; or a statement that is true of the structure"
    law = s.laws[0]
    hidden = "" if s.facts["detectable"] else " (or nothing: below noise and structure error)"
    if law.listed:
        return f"named {law.id}{hidden}"
    return f"unexplained at {' or '.join(s.facts['ports'])} by {' or '.join(s.facts['drivers'])}{hidden}"


def write_set(s: Set, folder: Path):
    """Writes the files; the truth is written last."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "experiment.toml").write_text(experiment(s), encoding="utf-8")
    for k in range(len(s.runs)):
        (folder / file_name(k)).write_text(csv(s, k), encoding="utf-8")
    part = folder / "truth.json.part"
    part.write_text(json.dumps(truth(s), indent=1) + "\n", encoding="utf-8")
    part.replace(folder / "truth.json")
