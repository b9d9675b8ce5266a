"""The model descriptions of the corpus: one table of variables for each model, written as XML of both standards."""

from dataclasses import dataclass, replace
from xml.sax.saxutils import quoteattr

#: A description that needs more than ASCII.
ACCENTED = "Verzögerung mit Übertragungsmaß"
#: Names of the types in FMI 2.
FMI2_TYPES = {"Float64": "Real", "Int32": "Integer"}


@dataclass(frozen=True)
class Variable:
    """One variable. `derivative_of` names a state; `depends_on` what an output or derivative depends on."""

    name: str
    reference: int
    causality: str
    start: str = ""
    type: str = "Float64"
    variability: str = ""
    derivative_of: str = ""
    depends_on: tuple[str, ...] = ()
    #: The clock that the variable belongs to.
    clock: str = ""
    #: Whether an event may change the state.
    reinit: bool = False


def parameter(name, reference, start, type="Float64"):
    return Variable(name, reference, "parameter", start, type, "fixed")


@dataclass(frozen=True)
class Model:
    """A model: the C file of its name, its variables after time, the stop time of its default experiment."""

    variables: tuple[Variable, ...]
    stop: str = "1"
    standards: tuple[int, ...] = (2, 3)
    interfaces: tuple[str, ...] = ("ModelExchange", "CoSimulation")
    event_indicator: str = ""
    event_mode: bool = False


LAG = (
    Variable("x", 1, "output", "0", depends_on=("x",)),
    Variable("der(x)", 2, "local", derivative_of="x", depends_on=("x", "u")),
    Variable("u", 3, "input", "1"),
    parameter("gain", 4, "1"),
    parameter("T", 5, "1"),
)
BALL = (
    Variable("h", 1, "output", "1", depends_on=("h",), reinit=True),
    Variable("v", 2, "output", "0", depends_on=("v",), reinit=True),
    Variable("der(h)", 3, "local", derivative_of="h", depends_on=("v",)),
    Variable("der(v)", 4, "local", derivative_of="v"),
    parameter("g", 5, "9.81"),
    parameter("e", 6, "0.7"),
    Variable("distance", 7, "local"),
)
STAIR = (Variable("level", 1, "output", type="Int32", variability="discrete"),)
SUM = (
    Variable("y", 1, "output", depends_on=("u", "v")),
    Variable("u", 2, "input", "0"),
    Variable("v", 3, "input", "0"),
    parameter("a", 4, "1"),
    parameter("b", 5, "1"),
)
TYPES = (
    parameter("low", 1, "-9007199254740993", "Int64"),
    parameter("high", 2, "18446744073709551615", "UInt64"),
    parameter("blob", 3, "00ff8041", "Binary"),
    Variable("low_out", 4, "output", type="Int64", variability="discrete"),
    Variable("high_out", 5, "output", type="UInt64", variability="discrete"),
    Variable("size", 6, "output", type="UInt64", variability="discrete"),
    Variable("echo", 7, "output", type="Binary", variability="discrete"),
    Variable("in", 8, "input", "0", type="Int64", variability="discrete"),
    Variable("through", 9, "output", type="Int64", variability="discrete", depends_on=("in",)),
)
CLOCK = (
    Variable("tick", 1, "input", type="Clock"),
    Variable("count", 2, "output", type="Int32", variability="discrete", depends_on=("tick",), clock="tick"),
)

MODELS = {
    "lag": Model(LAG),
    "ball": Model(BALL, stop="2", event_indicator="distance"),
    "stair": Model(STAIR),
    "sum": Model(SUM, interfaces=("CoSimulation",)),
    "types": Model(TYPES, standards=(3,), interfaces=("CoSimulation",)),
    "clock": Model(CLOCK, stop="0.95", standards=(3,), interfaces=("CoSimulation",), event_mode=True),
}


def many(count):
    """`count` further variables of the lag, which its quirk "many" computes."""
    return tuple(Variable(f"many.v{k}", 1000 + k, "local") for k in range(count))


def attributes(**values):
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in values.items() if value not in ("", None))


def initial(variable):
    """States that start at a value are exact; everything else keeps the standard's default."""
    return "exact" if variable.causality in ("output", "local") and variable.start else ""


class Table:
    """The variables with time in front, and what belongs together."""

    def __init__(self, model, further):
        self.all = (Variable("time", 0, "independent"), *model.variables, *further)
        self.place = {variable.name: k + 1 for k, variable in enumerate(self.all)}
        self.reference = {variable.name: variable.reference for variable in self.all}
        self.outputs = [v for v in self.all if v.causality == "output"]
        self.derivatives = [v for v in self.all if v.derivative_of]
        # Outputs and derivatives without an exact start are unknowns of the initialization; clocked variables need not be.
        self.initial = [v for v in (*self.outputs, *self.derivatives) if not initial(v) and not v.clock]


def flags(model, fmi, once):
    """The attributes of an interface."""
    state = "canGetAndSetFMUstate" if fmi == 2 else "canGetAndSetFMUState"
    out = {state: "true", state.replace("GetAndSet", "Serialize"): "true"}
    if fmi == 2:
        out["canNotUseMemoryManagementFunctions"] = "true"
    if once:
        out["canBeInstantiatedOnlyOncePerProcess"] = "true"
    return out


def interfaces(model, name, fmi, once, only):
    text = ""
    for interface in only or model.interfaces:
        further = {"canHandleVariableCommunicationStepSize": "true"} if interface == "CoSimulation" else {}
        if interface == "CoSimulation" and model.event_mode:
            further["hasEventMode"] = "true"
        text += f"  <{interface}{attributes(modelIdentifier=name, **further, **flags(model, fmi, once))}/>\n"
    return text


def xml(name, fmi, quirk="none", encoding="UTF-8", only=(), count=0):
    """The model description. `only` are the interfaces if not all of the model's; `count` belongs to the quirk "many"."""
    model = MODELS[name]
    if quirk == "reinit-undeclared":
        model = replace(model, variables=tuple(replace(v, reinit=False) for v in model.variables))
    table = Table(model, many(count) if quirk == "many" else ())
    header = {"fmiVersion": f"{fmi}.0", "modelName": name, "description": ACCENTED}
    if fmi == 2:
        indicators = {"numberOfEventIndicators": 1} if model.event_indicator else {}
        header |= {"guid": "{corpus}", **indicators}
    else:
        header |= {"instantiationToken": "{corpus}"}
    body = (fmi2 if fmi == 2 else fmi3)(table, model)
    return (
        f'<?xml version="1.0" encoding="{encoding}"?>\n<fmiModelDescription{attributes(**header)}>\n'
        + interfaces(model, name, fmi, quirk == "once", only)
        + '  <LogCategories>\n    <Category name="logStatus"/>\n  </LogCategories>\n'
        + f'  <DefaultExperiment startTime="0" stopTime="{model.stop}" tolerance="1e-6" stepSize="0.01"/>\n'
        + f"{body}</fmiModelDescription>\n"
    )


def fmi2(table, model):
    """Variables and structure of FMI 2: places, from 1, are the references."""

    def unknown(variable):
        return f"      <Unknown{attributes(index=table.place[variable.name])} dependencies={depends(variable)}/>\n"

    def depends(variable):
        return quoteattr(" ".join(str(table.place[name]) for name in variable.depends_on))

    def listed(element, variables):
        return f"    <{element}>\n{''.join(map(unknown, variables))}    </{element}>\n" if variables else ""

    lines = []
    for v in table.all:
        variability = "continuous" if v.causality == "independent" else v.variability
        outer = attributes(name=v.name, valueReference=v.reference, causality=v.causality, variability=variability, initial=initial(v))
        inner = attributes(start=v.start, derivative=table.place.get(v.derivative_of), reinit="true" if v.reinit else "")
        lines.append(f"    <ScalarVariable{outer}><{FMI2_TYPES[v.type]}{inner}/></ScalarVariable>\n")
    structure = listed("Outputs", table.outputs) + listed("Derivatives", table.derivatives) + listed("InitialUnknowns", table.initial)
    return f"  <ModelVariables>\n{''.join(lines)}  </ModelVariables>\n  <ModelStructure>\n{structure}  </ModelStructure>\n"


def fmi3(table, model):
    """Variables and structure of FMI 3."""

    def references(names):
        return " ".join(str(table.reference[name]) for name in names)

    def unknown(element, v):
        return f"    <{element} valueReference=\"{v.reference}\" dependencies={quoteattr(references(v.depends_on))}/>\n"

    lines = []
    for v in table.all:
        variability = "continuous" if v.causality == "independent" else v.variability
        given = attributes(name=v.name, valueReference=v.reference, causality=v.causality, variability=variability, initial=initial(v))
        if v.type == "Binary":
            start = f'><Start value="{v.start}"/></Binary>' if v.start else "/>"
            lines.append(f"    <Binary{given}{start}\n")
        elif v.type == "Clock":
            lines.append(f'    <Clock{given} intervalVariability="constant" intervalDecimal="0.1"/>\n')
        else:
            derivative, clocks = table.reference.get(v.derivative_of), table.reference.get(v.clock)
            reinit = "true" if v.reinit else ""
            lines.append(f"    <{v.type}{given}{attributes(start=v.start, derivative=derivative, reinit=reinit, clocks=clocks)}/>\n")
    structure = "".join(unknown("Output", v) for v in table.outputs)
    structure += "".join(unknown("ContinuousStateDerivative", v) for v in table.derivatives)
    structure += "".join(unknown("InitialUnknown", v) for v in table.initial)
    if model.event_indicator:
        structure += f'    <EventIndicator valueReference="{table.reference[model.event_indicator]}"/>\n'
    return f"  <ModelVariables>\n{''.join(lines)}  </ModelVariables>\n  <ModelStructure>\n{structure}  </ModelStructure>\n"
