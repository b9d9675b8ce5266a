"""A drawn set and its files: `experiment.toml`, `run-k.csv`, `truth.json`, in the format of the public bench sets."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .detect import findings, rms
from .generator import simulate
from .rig import Rig
from .sensors import described

# Of each run of a set, by their number. Of two runs the first is cut, what comes later validates.
ROLES = {
    2: (("fit", "validate"), ("test",)),
    3: (("fit",), ("validate",), ("test",)),
    4: (("fit",), ("fit",), ("validate",), ("test",)),
    5: (("fit",), ("fit",), ("fit",), ("validate",), ("test",)),
}
CUT = 0.65  # of a run, where it is cut
DIGITS = 5  # of a reading; times have all of theirs


@dataclass
class Run:
    """One file: imposed quantities, readings, and the readings of an ideal bench without the effects. `roles` has a window in s for each
    role, or None if all rows count.
    """

    roles: dict
    times: np.ndarray
    readings: dict
    truth: dict
    without: dict

    def rows(self, role: str) -> np.ndarray:
        """The rows that count in a role."""
        if role not in self.roles:
            return np.zeros(len(self.times), bool)
        begin, end = self.roles[role] or (-np.inf, np.inf)
        return (self.times >= begin) & (self.times <= end)


@dataclass
class Set:
    """One experiment: a specimen with its effects on a bench with its faults, in two to five runs."""

    name: str
    rig: Rig
    specimen: dict
    effects: list
    noise: dict
    noise_is_stated: bool
    faults: list
    runs: list

    def effects_in(self, run: int) -> list:
        return [e for e in self.effects if e.acts_in(run)]


def file_name(run: int) -> str:
    return f"run-{run + 1}.csv"


def toml_value(value) -> str:
    return json.dumps(value) if isinstance(value, (str, list)) else repr(value)


def toml_table(name: str, entries: dict) -> str:
    lines = [f"{key if key.isidentifier() else json.dumps(key)} = {toml_value(value)}" for key, value in entries.items()]
    return "\n".join([name, *lines]) + "\n"


def experiment(s: Set) -> str:
    """The text of `experiment.toml`."""
    head = {"name": s.name, "model": "AnnulusCooledMotor", "preset": "maxon-305015"}
    head |= {"inputs": list(s.rig.layout.inputs), "outputs": list(s.rig.layout.outputs)}
    runs = [
        {"file": file_name(k), "role": role} | ({"window_s": list(window)} if window else {})
        for k, run in enumerate(s.runs)
        for role, window in run.roles.items()
    ]
    tables = [
        toml_table("[experiment]", head),
        toml_table("[set]", {"cooling_mode": "conductance", "commutation": "equivalent_dc"} | s.rig.nominal),
        toml_table("[prior]", s.rig.prior),
        *([toml_table("[noise]", s.noise)] if s.noise_is_stated else []),
        *(toml_table("[[run]]", run) for run in runs),
    ]
    return "# Synthetic. See truth.json beside this set.\n" + "\n".join(tables)


def csv(run: Run) -> str:
    """The text of a run file; a missing reading is blank."""
    lines = [",".join(["time_s", *run.readings])]
    for t, *values in zip(run.times, *run.readings.values()):
        lines.append(",".join([f"{t:.10g}", *("" if np.isnan(v) else f"{v:.{DIGITS}g}" for v in values)]))
    return "\n".join(lines) + "\n"


def errors(s: Set) -> dict:
    """RMSE per role and channel of the untouched preset and of the true model, each driven by the measured inputs."""
    misses: dict = {}
    for k, run in enumerate(s.runs):
        models = {"before": ({}, []), "floor": (s.specimen, s.effects_in(k))}
        for model, (specimen, effects) in models.items():
            outputs = simulate(specimen, effects, run.times, run.readings, s.rig).outputs
            for role in run.roles:
                for c in s.rig.layout.outputs:
                    miss = (outputs[c] - run.readings[c])[run.rows(role)]
                    misses.setdefault(role, {}).setdefault(c, {}).setdefault(model, []).append(miss)

    def summed(by):
        return {model: float(f"{rms(np.concatenate(parts)):.4g}") for model, parts in by.items()}

    return {role: {c: summed(by) for c, by in channels.items()} for role, channels in misses.items()}


def acting(s: Set, effect) -> dict:
    """Port, driver and files of an effect."""
    files = [file_name(k) for k in range(len(s.runs)) if effect.acts_in(k)]
    return {"port": effect.law.port, "driver": effect.law.driver, "law": effect.law.text, "runs": files}


def rounded(values: dict) -> dict:
    return {name: float(f"{value:.3g}") for name, value in values.items()}


def truth(s: Set) -> dict:
    """The content of `truth.json`; `unexplained` is the unlisted effect, `shape` its name in the generator."""
    found, each = findings(s)
    listed = [(e, one) for e, one in zip(s.effects, each) if e.law.listed]
    others = [(e, one) for e, one in zip(s.effects, each) if not e.law.listed]
    sizes = [{"parameters": e.parameters | dict(e.law.fixed), "detectable": one.detectable} for e, one in listed]
    known = [{"id": e.law.id} | acting(s, e) | size for (e, _), size in zip(listed, sizes)]
    unknown = [{"shape": e.law.id} | acting(s, e) | e.parameters | {"detectable": one.detectable} for e, one in others]
    return {
        "name": s.name,
        "what": "; ".join(f"{e.law.id}: {e.law.text}" for e in s.effects) or "nothing is missing",
        "effects": known,
        "unexplained": unknown[0] if unknown else None,
        "parameters": s.specimen,
        "noise": s.noise,
        "sensors": described(s.faults),
        "signal_to_noise": rounded(found.plain),
        "signal_to_noise_refit": rounded(found.refit),
        "chi_square_refit": float(f"{found.chi_square:.3g}"),
        "detectable": found.detectable,
        "rmse": errors(s),
    }


def write_set(s: Set, folder: Path):
    """Writes the files of the set into `folder`, which is created; the truth is written last."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "experiment.toml").write_text(experiment(s), encoding="utf-8")
    for k, run in enumerate(s.runs):
        (folder / file_name(k)).write_text(csv(run), encoding="utf-8")
    whole = folder / "truth.json.part"
    whole.write_text(json.dumps(truth(s), indent=1) + "\n", encoding="utf-8")
    whole.replace(folder / "truth.json")
