"""Comparison of a report with the truth: reported effects, outcome, intervals, errors, cost."""

from dataclasses import dataclass, field

# Outcomes, in the order of the table's columns.
RIGHT = "right"
STRUCTURE = "true of the structure"  # no false alarm: the specimen has it, though it is not the effect of the set
CLASS_WITH = "class with it"
PORT_ONLY = "right port, other driver"
WRONG_PORT = "wrong port"
WRONG_NAME = "wrong name"
UNEXPLAINED = "unexplained"  # a listed effect that was not named
MISSED = "missed"
FALSE_ALARM = "false alarm"
BELOW = "not visible"  # the data do not show it, and nothing wrong was stated
TRACED = "traced to an effect"  # a mistake in the data
OTHER_CHANNEL = "noticed elsewhere"  # a mistake: recognised in another channel
UNNOTICED = "not noticed"
REFUSED_GOOD = "good data refused"
NO_REPORT = "no report"
OUTCOMES = (RIGHT, STRUCTURE, BELOW, CLASS_WITH, PORT_ONLY, WRONG_PORT, WRONG_NAME, UNEXPLAINED, MISSED, FALSE_ALARM)
OUTCOMES += (TRACED, OTHER_CHANNEL, UNNOTICED, REFUSED_GOOD, NO_REPORT)
# Names of outcomes on the page; the stored tables keep the names above.
TITLES = {
    RIGHT: "correct",
    STRUCTURE: "real difference",
    BELOW: "not visible, not reported",
    CLASS_WITH: "in a class with the true effect",
    UNEXPLAINED: "law instead of or besides the effect",
    TRACED: "mistake reported as an effect",
    OTHER_CHANNEL: "mistake recognised in another channel",
    UNNOTICED: "mistake not recognised",
}
FINE = (RIGHT, STRUCTURE, BELOW, CLASS_WITH)
NULL, LISTED, MISTAKE = "null", "listed", "mistake"
RANDOM = ("function", "product", "hidden")
MODELS = ("before", "refit", "after", "blackbox")
GENERIC = "generic_term"
VERDICTS = ("named", "class", "unexplained", "nothing", "unusable")
LOW = 0.5  # structure error, in standard deviations of the sensors, up to which a parameter has a true value
SPECIMEN, BEST = "specimen", "best two-node model"  # whose parameters are the true ones, in tables before and now


def title(outcome: str) -> str:
    """Name of an outcome on the page."""
    return TITLES.get(outcome, outcome)


@dataclass
class Said:
    """Content of a report: names, classes of names, port and drivers of a law without a name, unusable channel, notes;
    whether the law is a mass (a heat over the difference of a node's temperature and its lag).
    """

    names: list
    classes: list
    law: tuple | None
    unusable: str | None
    notes: list
    is_mass: bool = False

    @property
    def nothing(self) -> bool:
        return not (self.names or self.classes or self.law)

    @property
    def text(self) -> str:
        parts = [*self.names, *(" or ".join(sorted(c)) for c in self.classes)]
        if self.law:
            parts.append(f"{self.law[0]} by {' and '.join(self.law[1]) or 'a constant'}")
        if self.unusable:
            parts.append(f"unusable: {self.unusable}")
        return " + ".join(parts) or "nothing"


@dataclass
class Judged:
    """A set with its outcome; ratios are None without a report."""

    name: str
    kind: str
    truth: str
    said: str
    outcome: str
    structure: float = 0.0
    signal: float | None = None
    detectable: bool = True
    warm: bool = False
    verdict: str | None = None
    port: bool | None = None
    driver: bool | None = None
    compared: str = SPECIMEN
    inside: int = 0
    parameters: int = 0
    effective_inside: int = 0
    effective_parameters: int = 0
    over_floor: dict = field(default_factory=dict)  # by model: test error over the floor, in the worst channel
    over_model: dict = field(
        default_factory=dict
    )  # the same over floor and structure error: what the best two-node model with the law would have
    over_refit: float | None = None  # error after the repair over the refit's, all channels together
    over_refit_worst: float | None = None  # in the worst channel
    seconds: float | None = None
    budget: float | None = None
    cpu: float | None = None
    memory: float | None = None

    @property
    def sentence(self) -> str:
        ratios = ", ".join(f"{m} {v:.3g}" for m, v in self.over_floor.items())
        signal = "" if self.signal is None else f", effect {self.signal:.3g} sigma"
        errors = f"; test error / floor: {ratios}" if ratios else ""
        true = f"{self.truth} (structure error {self.structure:.2g} sigma{signal})"
        return f"{self.name}: {title(self.outcome)}: {true}; reported {self.said}{errors}"


def said_in(report: dict) -> Said:
    """A class is an effect with its alternatives, also beside a law; or else all effects of a report with that verdict."""
    verdict, effects = report["verdict"], [e for e in report.get("effects") or [] if e["id"] != GENERIC]
    if verdict not in VERDICTS:
        raise ValueError(f"the verdict {verdict!r} is none of {', '.join(VERDICTS)}")
    alike = [e for e in effects if e.get("alternatives") and verdict != "named"]
    classes = [{e["id"], *e["alternatives"]} for e in alike]
    names = [e["id"] for e in effects if e not in alike]
    if verdict == "class" and effects and not classes:
        names, classes = [], [{e["id"] for e in effects}]
    rest, unusable = report.get("unexplained"), report.get("unusable") or {}
    law = None
    if verdict == "unexplained" and rest:
        drivers = (rest.get("driver") or "").split(" and ")
        law = (rest["port"], [d for d in drivers if d])
    channel = f"{unusable.get('channel')}: {unusable.get('reason')}" if verdict == "unusable" else None
    terms = [(e.get("law") or {}).get("lag") or {} for e in report.get("effects") or []]
    is_mass = any(lag.get("difference") for lag in terms)
    return Said(names, classes, law, channel, [str(note) for note in report.get("notes") or []], is_mass)


def label(truth: dict) -> str:
    """The truth of a set in a few words."""
    if truth["mistake"]:
        return f"{truth['mistake']['id']} in {', '.join(filter(None, truth['mistake']['channels'])) or 'the file'}"
    if truth["effects"]:
        return " + ".join(e["id"] for e in truth["effects"])
    law = truth["law"]
    if not law:
        return "nothing"
    lag = f" behind {law['lag_s']:.0f} s" if "lag_s" in law else ""
    return f"{law['port']} by {' and '.join(law['drivers'])}{lag}"


def true_of_structure(truth: dict, said: Said) -> bool:
    """Whether everything that is reported is true of the structure; a mass at a node is a heat capacity."""
    true = truth["true_of_structure"]
    names = set(said.names).issubset(true["effects"]) and all(c & set(true["effects"]) for c in said.classes)
    is_capacity = said.is_mass and "heat_capacity" in true["ports"]
    return names and (not said.law or is_capacity or said.law[0] in true["ports"])


def of_mistake(truth: dict, said: Said | None, run: dict) -> str:
    """Data that are wrong: recognised, and nothing named that is not true of the specimen."""
    mistake = truth["mistake"]
    answers, channels = mistake["answers"], [c.rpartition("_")[0] or c for c in mistake["channels"]]
    if said is None:
        refused = run.get("exit_code") == 2 and run.get("error")
        return RIGHT if refused and "refused" in answers else REFUSED_GOOD if refused else NO_REPORT
    # What the specimen has beyond two nodes may be named beside a mistake that is recognised.
    traced = not said.nothing and not true_of_structure(truth, said)
    if "works" in answers:
        return REFUSED_GOOD if said.unusable else FALSE_ALARM if traced else RIGHT
    if traced:
        return TRACED
    if said.unusable:
        there = any(c in said.unusable for c in channels)
        return OTHER_CHANNEL if not there else RIGHT if "unusable" in answers else REFUSED_GOOD
    noted = [n for n in said.notes if any(c in n for c in channels) and ("set aside" in n or "note" in answers)]
    return RIGHT if noted and {"set aside", "note"} & set(answers) else UNNOTICED


def of_listed(truth: dict, said: Said) -> str:
    ids = {e["id"] for e in truth["effects"]}
    true = set(truth["true_of_structure"]["effects"])
    if not set(said.names) <= ids | true:
        return WRONG_NAME
    if ids & set(said.names):
        return RIGHT if not said.law or said.law[0] in truth["true_of_structure"]["ports"] else UNEXPLAINED
    if any(c & ids for c in said.classes):
        return CLASS_WITH
    if any(not c & true for c in said.classes):
        return WRONG_NAME
    if not truth["detectable"] and true_of_structure(truth, said):
        return BELOW
    return UNEXPLAINED if said.law else MISSED


def of_random(truth: dict, said: Said) -> str:
    """A law that is in no list has no name: any name that is not true of the structure is wrong."""
    true = set(truth["true_of_structure"]["effects"])
    if not set(said.names) <= true or any(not c & true for c in said.classes):
        return WRONG_NAME
    if not said.law:
        return BELOW if not truth["detectable"] else MISSED
    if said.law[0] in truth["ports"]:
        return RIGHT if set(said.law[1]) & set(truth["drivers"]) else PORT_ONLY
    return BELOW if not truth["detectable"] and true_of_structure(truth, said) else WRONG_PORT


def held(interval, value) -> bool:
    return interval is not None and interval[0] <= value <= interval[1]


def intervals(values: dict, report: dict) -> list:
    """Whether each value is inside its interval; a missing interval counts as outside."""
    return [held((report["parameters"].get(name) or {}).get("ci95"), value) for name, value in values.items()]


def sizes(truth: dict, report: dict) -> list:
    """The same for the parameters of listed effects that were found."""
    found = {e["id"]: e.get("parameters") or {} for e in report.get("effects") or []}
    pairs = [(found[e["id"]], n, v) for e in truth["effects"] if e["id"] in found for n, v in e["parameters"].items()]
    return [held((by.get(name) or {}).get("ci95"), value) for by, name, value in pairs if not isinstance(value, str)]


def over(floors: dict, error: dict) -> dict:
    """By model the test error over the floor, in the worst channel."""
    by = {
        m: [error[c][m] / floor for c, floor in floors.items() if (error.get(c) or {}).get(m) is not None]
        for m in MODELS
    }
    return {m: max(values) for m, values in by.items() if values}


def ratios(floors: dict, error: dict) -> tuple:
    """Error after the repair over the refit's, all channels together and in the worst one."""
    pairs = [
        (error[c]["after"], error[c]["refit"], f)
        for c, f in floors.items()
        if c in error and error[c].get("after") is not None
    ]
    if not pairs:
        return None, None
    together = (sum((a / f) ** 2 for a, _, f in pairs) / sum((r / f) ** 2 for _, r, f in pairs)) ** 0.5
    return together, max(a / r for a, r, _ in pairs)


def judge(truth: dict, report: dict | None, run: dict | None = None) -> Judged:
    """`report` is None if the program gave none; `run` has `exit_code`, `error`, `seconds`, `cpu_seconds`,
    `memory_MB`.
    """
    run, kind = run or {}, truth["kind"]
    said = said_in(report) if report else None
    if kind == MISTAKE:
        outcome = of_mistake(truth, said, run)
    elif said is None:
        outcome = NO_REPORT
    elif said.unusable:
        outcome = REFUSED_GOOD
    elif kind == NULL:
        outcome = RIGHT if said.nothing else STRUCTURE if true_of_structure(truth, said) else FALSE_ALARM
    else:
        outcome = (of_listed if kind == LISTED else of_random)(truth, said)
    text = said.text if said else run.get("error") or "no report"
    j = Judged(
        truth["name"],
        kind,
        label(truth),
        text,
        outcome,
        truth["structure_error_max"],
        truth.get("signal"),
        truth.get("detectable", True),
        compared=BEST,
    )
    j.warm, j.verdict = truth["warm"], report and report["verdict"]
    j.seconds, j.budget, j.cpu, j.memory = (
        run.get("seconds"),
        run.get("budget"),
        run.get("cpu_seconds"),
        run.get("memory_MB"),
    )
    if kind in RANDOM and j.detectable:
        law = said.law if said else None
        j.port = bool(law and law[0] in truth["ports"])
        j.driver = bool(law and set(law[1]) & set(truth["drivers"]))
    if report and not said.unusable and kind != MISTAKE:
        inside = intervals(truth["effective_parameters"], report)
        j.effective_inside, j.effective_parameters = sum(inside), len(inside)
        if j.structure <= LOW and not truth["wrong_prior"]:
            # The specimen's own parameters are not in the data where structure acts like other parameters.
            inside = inside + sizes(truth, report)
            j.inside, j.parameters = sum(inside), len(inside)
        floors, error = truth["floor"]["test"], report["error"].get("test") or {}
        both = {c: floor * (1.0 + truth["structure_error_test"].get(c, 0.0) ** 2) ** 0.5 for c, floor in floors.items()}
        j.over_floor, j.over_model = over(floors, error), over(both, error)
        j.over_refit, j.over_refit_worst = ratios(floors, error)
    return j
