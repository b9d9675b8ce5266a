"""Comparison of a report with the truth: reported effects, outcome, parameter intervals and errors."""

from dataclasses import dataclass, field

# Outcomes, in the order of the table's columns.
RIGHT = "right"  # nothing in a null set; the one name for each listed effect; port and driver of one that is in no list
CLASS_WITH = "class with it"  # listed: the truth is among two or three that the data cannot distinguish according to the report
PORT_ONLY = "right port, other driver"  # in no list
WRONG_PORT = "wrong port"  # in no list
CLASS_WITHOUT = "class without it"
WRONG_NAME = "wrong name"
UNEXPLAINED = "unexplained"  # listed: found but not named
MISSED = "missed"
FALSE_ALARM = "false alarm"
HIDDEN = "undetectable"  # the data do not show it, and nothing wrong was said
NO_REPORT = "no report"
OUTCOMES = (RIGHT, CLASS_WITH, PORT_ONLY, WRONG_PORT, CLASS_WITHOUT, WRONG_NAME, UNEXPLAINED, MISSED, FALSE_ALARM, HIDDEN, NO_REPORT)
FINE = (RIGHT, CLASS_WITH, HIDDEN)

NULL, LISTED, UNLISTED = "null", "listed", "unlisted"
GENERIC = "generic_term"  # the id of a term that has no name
MARGIN = 1.01  # of the refit's error: above it a repair is worse than none


@dataclass
class Said:
    """Content of a report: single names, classes of names, port and driver of an unlisted effect."""

    names: list
    classes: list
    unexplained: tuple | None

    @property
    def text(self) -> str:
        parts = [*self.names, *(" or ".join(sorted(c)) for c in self.classes)]
        if self.unexplained:
            port, driver = self.unexplained
            parts.append(f"{port} by {driver}" if driver else f"{port}, constant")
        return " + ".join(parts) or "nothing"


@dataclass
class Judged:
    """A set with its outcome."""

    name: str
    kind: str
    truth: str  # the row of the table
    said: str
    outcome: str
    named: list = field(default_factory=list)  # per listed effect that can be seen: RIGHT, CLASS_WITH or another outcome
    port: bool | None = None  # right? None where there is nothing in no list to be seen
    driver: bool | None = None
    inside: int = 0  # true parameters inside their 95 % interval
    parameters: int = 0  # of so many
    over_floor: float | None = None  # the test error after the repair over the floor, in the worst channel
    over_refit: float | None = None  # over the refit's, all channels together
    seconds: float | None = None
    memory: float | None = None  # MB

    @property
    def sentence(self) -> str:
        return f"{self.name}: {self.outcome}: true effect {self.truth}, reported {self.said}"


def said_in(report: dict) -> Said:
    """A class is an effect with its alternatives, or else all effects of a report with that verdict; an effect without alternatives is a
    name.
    """
    verdict, effects = report["verdict"], [e for e in report.get("effects", []) if e["id"] != GENERIC]
    names, classes = [], []
    if verdict == "class":
        classes = [{e["id"], *e["alternatives"]} for e in effects if e.get("alternatives")]
        names = [e["id"] for e in effects if not e.get("alternatives")] if classes else []
        if not classes and effects:
            classes = [{e["id"] for e in effects}]
    elif verdict in ("named", "unexplained"):
        names = [e["id"] for e in effects]
    elif verdict != "nothing":
        raise ValueError(f"the verdict {verdict!r} is none of named, class, unexplained, nothing")
    rest = report.get("unexplained") if verdict == "unexplained" else None
    return Said(names, classes, (rest["port"], rest.get("driver")) if rest else None)


def row(truth: dict) -> tuple:
    """Kind and row of a set."""
    ids = [e["id"] for e in truth["effects"]]
    other = truth["unexplained"]
    if other:
        return UNLISTED, " + ".join([other["shape"], *ids])
    return (LISTED, " + ".join(ids)) if ids else (NULL, "nothing")


def outcome_of_listed(effect: str, said: Said) -> str:
    if effect in said.names:
        return RIGHT
    if any(effect in c for c in said.classes):
        return CLASS_WITH
    return UNEXPLAINED if said.unexplained else MISSED


def outcome_of(kind: str, truth: dict, said: Said, named: list) -> str:
    """Outcome of a set; the worst one counts."""
    ids = {e["id"] for e in truth["effects"]}
    if kind == NULL:
        return FALSE_ALARM if said.names or said.classes or said.unexplained else RIGHT
    strange = [c for c in said.classes if not c & ids]
    # What is in no list has no name: also a class of names is wrong.
    if not ids.issuperset(said.names) or (strange and kind == UNLISTED):
        return WRONG_NAME
    if strange:
        return CLASS_WITHOUT
    seen = truth["unexplained"] and truth["unexplained"]["detectable"]
    worst = max(named, key=OUTCOMES.index, default=RIGHT)
    if not seen:
        if not named:
            return HIDDEN
        return UNEXPLAINED if said.unexplained and kind == LISTED else worst
    if not said.unexplained:
        return MISSED
    port, driver = (truth["unexplained"][key] == value for key, value in zip(("port", "driver"), said.unexplained))
    return max(worst, RIGHT if port and driver else PORT_ONLY if port else WRONG_PORT, key=OUTCOMES.index)


def held(interval, value) -> bool:
    return interval is not None and interval[0] <= value <= interval[1]


def intervals(truth: dict, report: dict):
    """Whether each true value is inside its interval: declared parameters, and sizes of effects that were found. A missing interval counts
    as outside.
    """
    for name, value in truth["parameters"].items():
        yield held(report["parameters"].get(name, {}).get("ci95"), value)
    found = {e["id"]: e.get("parameters", {}) for e in report.get("effects", [])}
    for effect in truth["effects"]:
        if effect["id"] in found:
            for name, value in effect["parameters"].items():
                if not isinstance(value, str):
                    yield held(found[effect["id"]].get(name, {}).get("ci95"), value)


def error_ratios(truth: dict, report: dict):
    """Test error after the repair: relative to the true floor in the worst channel, and relative to the refit's over all. Dead sensors do
    not count.
    """
    dead = {fault["channel"] for fault in truth["sensors"] if fault["kind"] == "dead"}
    floors = {channel: by["floor"] for channel, by in truth["rmse"]["test"].items() if channel not in dead}
    after, refit = ([report["error"]["test"][c][model] / floor for c, floor in floors.items()] for model in ("after", "refit"))
    return max(after), (sum(a * a for a in after) / sum(r * r for r in refit)) ** 0.5


def judge(truth: dict, report: dict | None, run: dict | None = None) -> Judged:
    """`report` is None if the program gave none; `run` has its `seconds` and `memory_MB`."""
    kind, label = row(truth)
    visible = [e["id"] for e in truth["effects"] if e.get("detectable", truth["detectable"])]
    other = truth["unexplained"]
    if other:
        truth = truth | {"unexplained": other | {"detectable": other.get("detectable", truth["detectable"])}}
    seen = bool(other and truth["unexplained"]["detectable"])
    if report is None:
        nothing = False if seen else None
        return Judged(truth["name"], kind, label, "no report", NO_REPORT, [NO_REPORT] * len(visible), nothing, nothing)
    said = said_in(report)
    named = [outcome_of_listed(effect, said) for effect in visible]
    judged = Judged(truth["name"], kind, label, said.text, outcome_of(kind, truth, said, named), named)
    if seen:
        port, driver = said.unexplained or (None, None)
        judged.port, judged.driver = port == other["port"], driver == other["driver"]
    inside = list(intervals(truth, report))
    judged.inside, judged.parameters = sum(inside), len(inside)
    judged.over_floor, judged.over_refit = error_ratios(truth, report)
    judged.seconds = (run or {}).get("seconds", report["seconds"])
    judged.memory = (run or {}).get("memory_MB")
    return judged
