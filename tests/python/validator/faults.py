"""The seeded faults: expected finding code, archive, change."""

import random
import re
import struct
import zipfile
from dataclasses import dataclass
from typing import Callable

from .archive import DESCRIPTION, lie_about_size, library
from .foreign import REFERENCE

#: Our archives, and the oscillator that is built from C: name of the base, standard.
OURS = {2: "gearmotor 2", 3: "gearmotor 3"}
FOREIGN = {2: "oscillator 2", 3: "oscillator 3"}


@dataclass(frozen=True)
class Fault:
    """One fault. `change` modifies the files of the base; `write` writes the archive in a special way."""

    code: str
    what: str
    base: str
    change: Callable = None
    write: Callable = None
    #: A fault of the oscillator's C source instead of a change.
    seed: str = ""


def edit(pattern, replacement, name=DESCRIPTION):
    """Replaces the first match of a regular expression, which must match."""

    def change(files):
        text, count = re.subn(pattern, replacement, files.entries[name].decode(), count=1, flags=re.S)
        assert count == 1, f"{name} has no {pattern}"
        files.entries[name] = text.encode()

    return change


def attribute(variable, name, value):
    """Sets an attribute of a variable of either standard, or adds it; None takes it away."""

    def change(files):
        text = files.entries[DESCRIPTION].decode()
        found = re.search(rf'<(\w+) name="{re.escape(variable)}"[^>]*?(/>|>\s*<\w+[^>]*?/>)', text, re.S)
        assert found, f"there is no variable {variable}"
        element = found.group(0)
        if value is None:
            new, count = re.subn(rf'\s{name}="[^"]*"', "", element, count=1)
            assert count, f"{variable} has no {name}"
        elif re.search(rf'\s{name}="', element):
            new = re.sub(rf'(\s{name}=")[^"]*"', rf'\g<1>{value}"', element, count=1)
        else:
            outer = name in ("causality", "variability", "initial")
            at = element.index(">") if outer else element.rindex(">")
            at -= element[at - 1] == "/"
            new = f'{element[:at]} {name}="{value}"{element[at:]}'
        files.entries[DESCRIPTION] = text.replace(element, new, 1).encode()

    return change


def add(name, content):
    """One more file."""

    def change(files):
        files.entries[name] = content.encode() if isinstance(content, str) else content

    return change


def variable(text):
    """One more variable, at the end of the list."""
    return edit(r"  </ModelVariables>", rf"    {text}\n  </ModelVariables>")


def unit(name, base):
    """One more unit, at the end of the list."""
    return edit(r"  </UnitDefinitions>", rf'    <Unit name="{name}"><BaseUnit {base}/></Unit>\n  </UnitDefinitions>')


def move_library(place, cut=None):
    """Puts the library somewhere else; `cut` keeps only its first bytes."""

    def change(files):
        name = library(files)
        content = files.entries.pop(name)
        files.entries[place] = content[:cut]

    return change


def cut(name, length):
    """Keeps the first bytes of a file."""

    def change(files):
        files.entries[name] = files.entries[name][:length]

    return change


def in_library(old, new):
    """Changes bytes of the library."""

    def change(files):
        files.replace(old, new, library(files))

    return change


def also(*extra):
    """Writes additional entries with names that a dictionary cannot hold."""
    return lambda files, path: files.write(path, extra)


def special(name, **properties):
    """Writes one further entry with properties of the zip format."""

    def write(files, path):
        files.write(path)
        info = zipfile.ZipInfo(name)
        for key, value in properties.items():
            setattr(info, key, value)
        with zipfile.ZipFile(path, "a") as file:
            file.writestr(info, b"/etc/passwd")
        return path

    return write


def bomb(files, path):
    """150 MB of zeros."""
    files.write(path)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as file, file.open("resources/zeros", "w") as zeros:
        for _ in range(150):
            zeros.write(bytes(1 << 20))
    return path


def small_bombs(files, path):
    """None of the entries is large."""
    return files.write(path, [(f"resources/zeros-{k}", bytes(10 << 20)) for k in range(40)])


def shared_bytes(files, path):
    """Entries of the directory that all point to the largest one: the archive is smaller than the sum of its entries."""
    files.write(path, [(f"resources/copy-{k}", bytes(range(256)) * 8) for k in range(3)] + [("resources/noise", random.Random(1).randbytes(1 << 20))])
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        large = archive.getinfo("resources/noise")
    at = content.index(b"PK\1\2")
    for _ in range(len(zipfile.ZipFile(path).namelist())):
        name_length, extra, comment = struct.unpack_from("<HHH", content, at + 28)
        if content[at + 46 : at + 46 + name_length].startswith(b"resources/copy"):
            struct.pack_into("<LLL", content, at + 16, large.CRC, large.compress_size, large.file_size)
            struct.pack_into("<L", content, at + 42, large.header_offset)
            struct.pack_into("<H", content, at + 10, large.compress_type)
        at += 46 + name_length + extra + comment
    path.write_bytes(content)
    return path


def into_subfolder(files, path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in files.entries.items():
            file.writestr(f"model/{name}", content)
    return path


LICENSE = "documentation/licenses/license.txt"


def license_elsewhere(files):
    files.entries["documentation/licenses/terms.pdf"] = files.entries.pop(LICENSE)


TERMINALS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals><Terminal name="shaft" '
    'matchingRule="plug">{}</Terminal></Terminals></fmiTerminalsAndIcons>'
)
MEMBER = '<TerminalMemberVariable variableName="{}" memberName="{}" variableKind="signal"/>'
BUILD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="{}">'
    '<SourceFileSet><SourceFile name="{}"/></SourceFileSet></BuildConfiguration></fmiBuildDescription>'
)
ICONS = "terminalsAndIcons/terminalsAndIcons.xml"

ARCHIVE = [
    Fault("entry-outside", "an entry leads out of the folder (zip slip)", OURS[2], write=also(("../evil.sh", b"x"))),
    Fault("entry-absolute", "an entry has an absolute path", OURS[3], write=also(("/tmp/evil.sh", b"x"))),
    Fault("entry-backslash", "a backslash separates folders", FOREIGN[2], write=special("resources", filename="resources\\x.txt")),
    Fault("entry-duplicate", "modelDescription.xml occurs twice", FOREIGN[3], write=also((DESCRIPTION, b"<x/>"))),
    Fault("entry-case", "two names differ only in upper and lower case", FOREIGN[2], write=also(("MODELDESCRIPTION.XML", b"<x/>"))),
    Fault(
        "entry-link",
        "a symbolic link to /etc/passwd",
        FOREIGN[3],
        write=special("resources/link", create_system=3, external_attr=0o120777 << 16),
    ),
    Fault("entry-method", "an entry is compressed with bzip2", FOREIGN[2], write=special("resources/x", compress_type=zipfile.ZIP_BZIP2)),
    Fault("entry-damaged", "an entry declares a wrong size", FOREIGN[3], write=lambda files, path: lie_about_size(files.write(path))),
    Fault("archive-bomb", "150 MB of zeros", FOREIGN[2], write=bomb),
    Fault("archive-bomb", "forty entries of 10 MB of zeros each", OURS[3], write=small_bombs),
    Fault("archive-bomb", "three entries share their bytes", FOREIGN[3], write=shared_bytes),
    Fault("model-description-missing", "everything is in a subfolder", OURS[3], write=into_subfolder),
]
XML = [
    Fault(
        "xml-doctype", "a document type with an entity", OURS[2], edit(r"\?>", r'?><!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>')
    ),
    Fault("xml-malformed", "an end tag is missing", FOREIGN[2], edit(r"</ModelStructure>", "")),
    Fault("xml-encoding", "the file declares the encoding Latin-1", FOREIGN[3], edit("UTF-8", "ISO-8859-1")),
    Fault("xsd-attribute-unknown", "an attribute that is not in the schema", OURS[2], attribute("duty", "colour", "red")),
    Fault("xsd-attribute-missing", "a variable without value reference", OURS[3], attribute("duty", "valueReference", None)),
    Fault("xsd-attribute-value", "a start value that is not a number", OURS[2], attribute("thermal.C_h", "start", "many")),
    Fault("attribute-huge", "a description of a million characters", FOREIGN[3], edit(r'modelName="', f'description="{"x" * 10**6}" modelName="')),
    Fault(
        "xsd-element-order",
        "log categories before the units",
        FOREIGN[2],
        edit(r"(  <UnitDefinitions>.*)(  <LogCategories>.*?</LogCategories>\n)", r"\2\1"),
    ),
    Fault("xsd-element-missing", "no model structure", FOREIGN[3], edit(r"<ModelStructure>.*</ModelStructure>", "")),
    Fault("xsd-element-unknown", "an element that is not in the schema", OURS[3], edit(r"<ModelVariables>", "<Colours/><ModelVariables>")),
]
MEANING = [
    Fault("start-outside", "a start value above its max", OURS[2], attribute("thermal.C_h", "start", "1e9")),
    Fault("start-outside", "an integer's start value below its min", FOREIGN[3], attribute("solver", "start", "0")),
    Fault("limits-crossed", "min above max", OURS[3], attribute("thermal.C_h", "min", "1e9")),
    Fault("unit-undefined", "a unit that is not defined", OURS[2], attribute("duty", "unit", "percent")),
    Fault("display-unit-undefined", "a display unit that belongs to another unit", OURS[3], attribute("duty", "displayUnit", "degC")),
    Fault("unit-factor", "a unit with the factor 0", FOREIGN[2], edit(r'factor="1000"', 'factor="0"')),
    Fault("unit-contradiction", "degrees Celsius without offset", OURS[2], edit(r'(<DisplayUnit name="degC"[^>]*) offset="[^"]*"', r"\1")),
    Fault("unit-contradiction", "degrees Celsius with the wrong sign", OURS[3], edit(r'offset="-273.15"', 'offset="273.15"')),
    Fault(
        "unit-contradiction",
        "degrees Fahrenheit with the factor of degrees Celsius",
        FOREIGN[2],
        edit(r"  </UnitDefinitions>", r'    <Unit name="degF"><BaseUnit K="1" offset="255.37"/></Unit>\n  </UnitDefinitions>'),
    ),
    Fault(
        "unit-contradiction",
        "revolutions per minute with the factor of revolutions per second",
        OURS[3],
        edit(r'(<DisplayUnit name="rpm" factor=")[^"]*"', r'\g<1>0.15915494"'),
    ),
    Fault("unit-contradiction", "millinewton metres without a factor", FOREIGN[3], unit('mN.m', 'kg="1" m="2" s="-2"')),
    Fault("unit-exponents", "a torque with the exponents of a power", OURS[2], edit(r'(<Unit name="N.m">\s*<BaseUnit kg="1" m="2" s=)"-2"', r'\1"-3"')),
    Fault("unit-exponents", "a heat transfer coefficient with those of a conductance", FOREIGN[2], unit("W/(m2.K)", 'kg="1" m="2" s="-3" K="-1"')),
    Fault("display-unit-ignored", "a display unit that is not defined", OURS[2], attribute("duty", "displayUnit", "%")),
    Fault("nominal-doubtful", "a parameter with the nominal value 0", FOREIGN[2], attribute("damping", "nominal", "0")),
    Fault("nominal-state", "a state with the nominal value 0", FOREIGN[3], attribute("v", "nominal", "0")),
    Fault("initial-not-allowed", "an input with initial = calculated", OURS[3], attribute("duty", "initial", "calculated")),
    Fault("unit-repeated", "a unit defined twice", FOREIGN[3], edit(r'<Unit name="m/s">', '<Unit name="m">')),
    Fault(
        "item-repeated",
        "two items of an enumeration with the same value",
        OURS[2],
        edit(r'(<Item name="\w+" value=")(\d+)("[^>]*>\s*<Item name="\w+" value=")\d+', r"\1\2\3\2"),
    ),
    Fault("type-undefined", "a declared type without definition", FOREIGN[2], edit(r'declaredType="Position"', 'declaredType="Place"')),
    Fault("causality-variability", "a continuous parameter", OURS[3], attribute("thermal.C_h", "variability", "continuous")),
    Fault("start-missing", "a parameter without start value", OURS[2], attribute("thermal.C_h", "start", None)),
    Fault("start-forbidden", "a start value of a calculated variable", OURS[3], attribute("winding_temperature", "start", "300")),
    Fault("initial-not-allowed", "a parameter with initial = calculated", FOREIGN[2], attribute("damping", "initial", "calculated")),
    Fault("continuous-not-float", "a continuous Boolean", FOREIGN[3], attribute("beyond", "variability", "continuous")),
    Fault("name-repeated", "two variables with the same name", OURS[2], attribute("thermal.C_h", "name", "duty")),
    Fault("name-syntax", "a name that violates the structured naming convention", OURS[3], attribute("thermal.C_h", "name", "thermal C_h")),
    Fault("value-reference-repeated", "two variables with the same value reference", OURS[3], attribute("thermal.C_h", "valueReference", "1")),
    Fault("alias-start", "two start values for one value reference", FOREIGN[2], attribute("damping", "valueReference", "9")),
    Fault("alias-unit", "an alias with another unit", FOREIGN[2], attribute("power", "valueReference", "12")),
    Fault("output-not-listed", "an output that is missing in the model structure", FOREIGN[3], edit(r'<Output valueReference="6"[^>]*>', "")),
    Fault("initial-unknown-missing", "an initial unknown that is not listed", FOREIGN[2], edit(r'<Unknown index="5"/>', "")),
    Fault("unknown-repeated", "an output listed twice", OURS[3], edit(r'(<Output valueReference="22"[^>]*/>)', r"\1\1")),
    Fault("dependency-reference", "a dependency on an undefined variable", FOREIGN[3], edit(r'dependencies="2 5"', 'dependencies="2 99"')),
    Fault(
        "dependencies-kind-length",
        "fewer kinds than dependencies",
        FOREIGN[2],
        edit(r'dependencies="3 6"', 'dependencies="3 6" dependenciesKind="dependent"'),
    ),
    Fault("derivative-reference", "the derivative of an undefined variable", FOREIGN[3], attribute("der(v)", "derivative", "99")),
    Fault("derivative-target", "the derivative of a Boolean", FOREIGN[3], attribute("der(v)", "derivative", "20")),
    Fault("derivative-name", "der(v) declared as derivative of x", FOREIGN[2], attribute("der(v)", "derivative", "2")),
    Fault("derivative-unit", "a derivative whose unit is not that of its state per second", FOREIGN[3], attribute("der(v)", "unit", "W")),
    Fault(
        "event-indicator",
        "a Boolean event indicator",
        FOREIGN[3],
        edit(r'EventIndicator valueReference="13"', 'EventIndicator valueReference="20"'),
    ),
    Fault("default-experiment", "a stop time before the start time", OURS[2], edit(r'stopTime="[^"]*"', 'stopTime="-1"')),
    Fault(
        "model-identifier",
        "a modelIdentifier that is not a C identifier",
        FOREIGN[2],
        edit(r'CoSimulation modelIdentifier="oscillator"', 'CoSimulation modelIdentifier="2nd-order"'),
    ),
    Fault("capability-requires", "serialization declared without get and set of states", OURS[2], edit(r' canGetAndSetFMUstate="true"', "")),
    Fault("token-empty", "an empty token", FOREIGN[3], edit(r'instantiationToken="[^"]*"', 'instantiationToken=""')),
    Fault(
        "dimension",
        "an array dimension given by a real parameter",
        FOREIGN[3],
        variable('<Float64 name="row" valueReference="40"><Dimension valueReference="7"/></Float64>'),
    ),
    Fault(
        "start-count",
        "two start values for three elements",
        FOREIGN[3],
        variable(
            '<Float64 name="row" valueReference="40" causality="parameter" variability="fixed" start="1 2"><Dimension start="3"/></Float64>'
        ),
    ),
    Fault(
        "clock-interval",
        "a periodic clock without interval",
        FOREIGN[3],
        variable('<Clock name="tick" valueReference="40" causality="input" intervalVariability="constant"/>'),
    ),
]
FILES = [
    Fault(
        "binary-missing",
        "a library with another name than modelIdentifier",
        OURS[2],
        lambda files: move_library(library(files).replace(".", "_2."))(files),
    ),
    Fault(
        "binary-architecture",
        "a Linux library in the folder of Windows",
        OURS[3],
        move_library("binaries/x86_64-windows/BrushedGearmotor.dll"),
    ),
    Fault("binary-format", "a truncated library", FOREIGN[2], lambda files: move_library(library(files), 200)(files)),
    Fault("symbol-missing", "a library without fmi2Reset", FOREIGN[2], in_library(b"fmi2Reset\0", b"fmi2Rexet\0")),
    Fault(
        "symbol-missing",
        "a library without fmi3GetAdjointDerivative",
        FOREIGN[3],
        in_library(b"fmi3GetAdjointDerivative\0", b"fmi3GetAdjointDerivatibe\0"),
    ),
    Fault("platform-of-fmi2", "the FMI 2 name of a platform in FMI 3", FOREIGN[3], move_library("binaries/linux64/oscillator.so")),
    Fault("platform-unknown", "a platform that no standard names", FOREIGN[2], add("binaries/solaris/oscillator.so", "x")),
    Fault("no-implementation", "neither binaries nor sources", FOREIGN[2], lambda files: files.entries.pop(library(files))),
    Fault(
        "terminal-variable",
        "a terminal with a variable that does not exist",
        OURS[3],
        add(ICONS, TERMINALS.format(MEMBER.format("torque", "tau"))),
    ),
    Fault(
        "member-name",
        "two members of a terminal with one name",
        FOREIGN[2],
        add(ICONS, TERMINALS.format(MEMBER.format("x", "a") + MEMBER.format("power", "a"))),
    ),
    Fault("svg-without-png", "an icon as SVG alone", FOREIGN[3], add("terminalsAndIcons/icon.svg", "<svg/>")),
    Fault("picture-unreadable", "a text as the icon", OURS[2], add("model.png", "an icon")),
    Fault("picture-unreadable", "the icon of the terminals is cut off", OURS[3], cut("terminalsAndIcons/icon.png", 900)),
    Fault("picture-unreadable", "an icon that is a web page", OURS[2], add("terminalsAndIcons/icon.svg", "<html/>")),
    Fault("build-description-missing", "source code without build description", FOREIGN[3], add("sources/model.c", "int x;")),
    Fault(
        "source-file-missing",
        "a listed source file is missing",
        FOREIGN[3],
        add("sources/buildDescription.xml", BUILD.format("oscillator", "model.c")),
    ),
    Fault("license-entry", "a licence folder without an entry point", FOREIGN[3], license_elsewhere),
    Fault("documentation-missing", "no documentation", FOREIGN[2], lambda files: files.entries.pop("documentation/index.html")),
    Fault("license-missing", "no licence", FOREIGN[3], lambda files: files.entries.pop(LICENSE)),
]
#: Model description and library are each right, and do not fit together.
TOGETHER = [
    Fault(
        "instantiate",
        "the XML has the GUID of another build",
        OURS[2],
        edit(r'guid="[^"]*"', 'guid="{0a1b2c3d-0000-4000-8000-0123456789ab}"'),
    ),
    Fault("start-differs", "a start value that differs from the library's", OURS[3], attribute("thermal.C_h", "start", "86")),
    Fault(
        "dependency-undeclared",
        "a dependency is left out",
        OURS[2],
        edit(r'(<Outputs>\s*<Unknown index="\d+" dependencies=")[^"]*"', r'\1"'),
    ),
    Fault(
        "dependency-undeclared",
        "an input is left out of the dependencies of a derivative",
        FOREIGN[2],
        edit(r'index="5" dependencies="2 3 6"', 'index="5" dependencies="2 3"'),
    ),
    Fault("value-outside", "an output outside its declared limits", OURS[3], attribute("winding_temperature", "max", "200")),
    Fault("reference-file", "listed reference results are missing", FOREIGN[2], lambda files: files.entries.pop(REFERENCE)),
    Fault("reference-column", "reference results of a variable that does not exist", FOREIGN[3], edit("time,x", "time,place", REFERENCE)),
    Fault("reference-column", "reference results with NaN in one row", FOREIGN[2], edit(r"(\n[^\n]*\n[^\n,]*,)[^\n,]*", r"\1NaN", REFERENCE)),
    Fault(
        "output-derivative-order",
        "output derivatives of a higher order than the library gives",
        FOREIGN[2],
        edit('maxOutputDerivativeOrder="1"', 'maxOutputDerivativeOrder="3"'),
    ),
    Fault(
        "life-cycle",
        "a value reference that is unknown to the library",
        OURS[2],
        attribute("winding_temperature", "valueReference", "9999"),
    ),
    Fault("derivative-value", "the angle declared as derivative of the temperature", OURS[3], attribute("shaft_angle", "derivative", "25")),
    Fault(
        "states-number",
        "a state that is missing in the model structure",
        FOREIGN[3],
        edit(r'<ContinuousStateDerivative valueReference="3"[^>]*>', ""),
    ),
]


def seeded(code, what, seed, fmi):
    return Fault(code, what, FOREIGN[fmi], seed=seed)


BEHAVIOUR = [
    seeded("crash", "a step writes to invalid memory", "crash", 2),
    seeded("crash", "a step calls abort", "abort", 3),
    seeded("crash", "a step calls exit", "exit", 2),
    seeded("crash", "freeing NULL crashes", "free_null", 3),
    seeded("crash-on-misuse", "an input of NaN calls exit", "nan_crash", 2),
    seeded("hang", "a step never returns", "hang", 2),
    seeded("instantiate", "instantiation returns NULL", "instantiate", 3),
    seeded("version-string", "fmi2GetVersion returns 1.0", "version", 2),
    seeded("version-release", "fmi2GetVersion returns 2.0.5", "version_release", 2),
    seeded("version-string", "another types platform than default", "platform", 2),
    seeded("token-unchecked", "any token is accepted", "token", 3),
    seeded("life-cycle", "the fourth step fails", "step_error", 2),
    seeded("life-cycle", "termination fails", "terminate", 3),
    seeded("life-cycle", "reset fails", "reset_error", 2),
    seeded("life-cycle", "event mode fails", "event_mode", 3),
    seeded("life-cycle", "a step returns early although this is not allowed", "early_return", 3),
    seeded("output-not-finite", "an output is NaN", "output_nan", 2),
    seeded("value-outside", "an output is below its min", "value_outside", 3),
    seeded("logger-environment", "the logger gets another environment pointer", "environment", 2),
    seeded("log-category-undeclared", "messages in an undeclared category", "log_category", 2),
    seeded("start-differs", "a parameter starts at another value", "start", 3),
    seeded("start-differs", "a string starts at another value", "start_text", 2),
    seeded("set-lost", "a parameter ignores the value that is set", "set_lost", 3),
    seeded("tunable-refused", "a tunable parameter cannot be set after the start", "tunable_refused", 2),
    seeded("tunable-refused", "the same in event mode", "tunable_refused", 3),
    seeded("set-order", "setting one parameter changes another", "set_order", 2),
    seeded("set-start", "setting the present value changes the dynamics", "set_disturbs", 3),
    seeded("get-changes", "reading changes the state", "get_changes", 2),
    seeded("not-deterministic", "results contain random numbers", "random", 3),
    seeded("reset", "reset does nothing", "reset_nothing", 2),
    seeded("reset", "reset keeps a parameter", "reset_parameter", 3),
    seeded("instances", "two instances share an input", "instances_share", 2),
    seeded("memory", "instances are not freed", "leak_instance", 3),
    seeded("memory", "saved states are not freed", "leak_state", 2),
    seeded("memory", "each step leaks 64 bytes", "leak_step", 3),
    seeded("rollback", "a saved state lacks a continuous state", "rollback", 2),
    seeded("rollback", "a saved state lacks the input", "rollback_input", 3),
    seeded("state-pointer", "the pointer to a freed state is not set to NULL", "state_pointer", 2),
    seeded("serialize", "a serialized state lacks a continuous state", "serialize", 3),
    seeded("step-size", "each step is 10 ms, independent of the requested size", "step_ignored", 2),
    seeded("stop-time", "steps after the stop time are accepted", "stop_time", 3),
    seeded("derivative-value", "a declared derivative is 2 % too large", "derivative_declared", 2),
    seeded("exchange-differs", "the spring is 2 % too stiff in Co-Simulation", "dynamics_steps", 3),
    seeded("exchange-differs", "the spring is 2 % too stiff in Model Exchange", "dynamics_exchange", 2),
    seeded("reference-differs", "the spring is 2 % too stiff everywhere", "dynamics", 3),
    seeded("output-derivative", "a derivative of an output is 5 % too large", "output_derivative", 3),
    seeded("input-derivative", "input derivatives are ignored", "input_derivative", 2),
    seeded("directional-derivative", "a directional derivative is 2 % too large", "directional", 3),
    seeded("directional-derivative", "a directional derivative has the wrong sign", "directional_sign", 2),
    seeded("adjoint-derivative", "adjoint derivatives are 2 % too large", "adjoint", 3),
    seeded("dependency-undeclared", "an output has an undeclared dependency", "dependency", 2),
    seeded("states-order", "states in another order than their derivatives", "states_order", 3),
    seeded("states-kept", "setting the states omits one", "states_kept", 2),
    seeded("states-number", "more states than in the model structure", "states_number", 3),
    seeded("nominal-value", "nominal values of states are 0", "nominal", 2),
    seeded("evaluation-memory", "derivatives change from call to call", "evaluation_memory", 3),
    seeded("reinit", "an event changes a state without reinit", "reinit", 2),
    seeded("indicator-jumps", "an event indicator is +1 or -1", "indicator_jumps", 2),
    seeded("event-iteration", "the event iteration never ends", "events_forever", 3),
    seeded("event-iteration", "the next time event is one second in the past", "event_past", 2),
    seeded("reference-unchecked", "any value reference can be read", "reference", 3),
    seeded("constant-settable", "a constant can be set", "constant_settable", 2),
    seeded("nan-accepted", "NaN is accepted as a value", "nan_accepted", 3),
    seeded("range-unchecked", "values outside the limits are accepted", "range_unchecked", 2),
]

GROUPS = [
    ("The archive", ARCHIVE),
    ("XML and schema", XML),
    ("Semantics of the model description", MEANING),
    ("Other files and libraries", FILES),
    ("Model description compared with library", TOGETHER),
    ("Behaviour", BEHAVIOUR),
]
ALL = [fault for _, faults in GROUPS for fault in faults]
