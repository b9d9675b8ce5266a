"""Contents of an archive besides description and library: page, licences, icon, terminals, reference results."""

import csv
import io
import re
import struct
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pyssp_standard
import pytest
import xmlschema
from clients import paths
from conftest import STANDARDS

MODELS = sorted(path.stem for path in (paths.dist() / "fmi2").glob("*.fmu"))
MOTOR_TERMINALS = ["electrical", "shaft", "heat"]
TERMINALS = {
    "AnnulusCooledMotor": MOTOR_TERMINALS,
    "BrushedGearmotor": MOTOR_TERMINALS,
    "SeriesElasticActuator": ["motor", "drive", "joint", "supply"],
    "GaitLoad": ["joint"],
}
# An output of each that is far from zero at the end of a second.
HEADLINE = {
    "AnnulusCooledMotor": "shaft_speed",
    "BrushedGearmotor": "shaft_speed",
    "SeriesElasticActuator": "joint_torque",
    "GaitLoad": "torque_demand",
}
MOST_BYTES = 3 << 20
REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"
NAMES = "{http://fmi-standard.org/fmi-ls-manifest}"


@pytest.fixture(params=[(model, fmi) for model in MODELS for fmi in STANDARDS], ids=lambda p: f"{p[0]}-fmi{p[1]}")
def packed(request):
    """Model, standard, path, and the files of the archive by name."""
    model, fmi = request.param
    path = paths.archive(model, fmi)
    with zipfile.ZipFile(path) as archive:
        return model, fmi, path, {name: archive.read(name) for name in archive.namelist()}


def test_an_archive_is_small(packed):
    assert packed[2].stat().st_size <= MOST_BYTES


def test_one_library_and_for_this_platform_alone(packed):
    """A platform is in the archive only with `--platform`, and then its own library."""
    model, _, _, files = packed
    binaries = [name for name in files if name.startswith("binaries/")]
    assert len(binaries) == 1 and binaries[0].rsplit("/", 1)[1].split(".")[0] == model


def test_the_page_opens_without_a_network(packed):
    page = packed[3]["documentation/index.html"].decode()
    addresses = set(re.findall(r"https?://[^\"' <]+", page))
    assert addresses <= {"http://www.w3.org/2000/svg"}, addresses
    assert not re.search(r"<(script|link|img|iframe)", page)
    assert page.count("<svg") == page.count("</figure>") == 3
    for svg in re.findall(r"<svg.*?</svg>", page, re.S):
        ElementTree.fromstring(svg)


def test_the_page_shows_every_variable_with_its_unit(packed):
    files = packed[3]
    page = files["documentation/index.html"].decode()
    description = ElementTree.fromstring(files["modelDescription.xml"])
    variables = [v for v in description.find("ModelVariables") if v.get("causality") in ("input", "output", "parameter")]
    assert len(variables) > 15
    for variable in variables:
        real = variable.find("Real") if variable.tag == "ScalarVariable" else variable if variable.tag == "Float64" else None
        unit = "" if real is None else real.get("unit")
        # The page lists the elements of an array, which in FMI 2 are variables of their own.
        name = variable.get("name") + ("" if variable.find("Dimension") is None else "[1]")
        assert re.search(f"<code>{re.escape(name)}</code></td><td[^>]*>{re.escape(unit or '')}</td>", page), name


def test_the_page_s_script_runs(packed, monkeypatch, tmp_path):
    """The lines of `First simulation` as a reader copies them."""
    model, _, path, files = packed
    script = re.search(r"<pre>(.*?)</pre>", files["documentation/index.html"].decode(), re.S)[1].replace("&quot;", '"')
    shown = []
    monkeypatch.chdir(path.parent)
    monkeypatch.setattr("fmpy.plot_result", shown.append)
    exec(compile(script, "index.html", "exec"), {})
    (result,) = shown
    assert len(result) > 100 and len(result.dtype.names) > 3
    assert abs(result[HEADLINE[model]][-1]) > 1.0


def test_licences_are_there(packed):
    _, _, _, files = packed
    folder = "documentation/licenses"
    root = ElementTree.fromstring(files["modelDescription.xml"])
    assert root.get("license") == "MIT AND CC0-1.0 AND LicenseRef-CC-BY-SA" and root.get("author") and root.get("copyright")
    assert not [name for name in files if name.startswith("licenses")]
    assert files[f"{folder}/license.txt"] == (paths.ROOT / "LICENSE").read_bytes()
    third = files[f"{folder}/third-party.txt"].decode()
    licences = files[f"{folder}/gait-data.txt"].decode()
    # The adults of the default first, then the children.
    assert 0 <= licences.find("CC0 1.0") < licences.find("CC-BY-SA")
    assert re.search(r"^nalgebra [0-9.]+: Apache-2.0$", third, re.M) and "Apache License" in third


def test_the_icon_is_a_picture(packed):
    _, fmi, _, files = packed
    png = files["model.png" if fmi == 2 else "terminalsAndIcons/icon.png"]
    assert png.startswith(b"\x89PNG\r\n\x1a\n") and struct.unpack(">II", png[16:24]) == (200, 200)
    ElementTree.fromstring(files["terminalsAndIcons/icon.svg"])


def test_terminals_name_variables_of_the_model(packed):
    model, _, _, files = packed
    terminals = ElementTree.fromstring(files["terminalsAndIcons/terminalsAndIcons.xml"])
    assert all(t.get("terminalKind") for t in terminals.iter("Terminal"))
    causalities = {v.get("name"): v.get("causality") for v in ElementTree.fromstring(files["modelDescription.xml"]).find("ModelVariables")}
    assert [t.get("name") for t in terminals.iter("Terminal")] == TERMINALS[model]
    for member in terminals.iter("TerminalMemberVariable"):
        assert causalities[member.get("variableName")] in ("input", "output"), member.get("variableName")


def test_the_manifest_names_files_that_are_there(packed):
    model, _, _, files = packed
    manifest = ElementTree.fromstring(files[f"{REFERENCE}/fmi-ls-manifest.xml"])
    assert manifest.tag == "fmiReferences" and manifest.get(f"{NAMES}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    related = {r.get("role"): r.get("source") for r in manifest.iter("Related")}
    assert related == {"testcase": f"{model}_in.csv", "result": f"{model}_ref.csv", "document": "../../documentation/index.html"}
    assert {f"{REFERENCE}/{related['testcase']}", f"{REFERENCE}/{related['result']}", "documentation/index.html"} <= set(files)


def test_the_library_gives_the_reference_results(packed, motor_fmu, tmp_path):
    """The reference inputs of the archive with its library give the stored results of the native model, bit for bit."""
    model, _, path, files = packed
    inputs, out = tmp_path / "inputs.csv", tmp_path / "out.csv"
    inputs.write_bytes(files[f"{REFERENCE}/{model}_in.csv"])
    arguments = ("--stop", 1, "--step", 1e-3, "--input", inputs, "--no-input-derivatives", "--output", out)
    done = motor_fmu("simulate", path, *arguments)
    assert done.returncode == 0, done.stderr
    reference = table(files[f"{REFERENCE}/{model}_ref.csv"].decode())
    # The results hold scalars; an importer of FMI 3 reads the housing's segments as well.
    played = [{name: row[name] for name in reference[0]} for row in table(out.read_text())[::10]]
    assert len(reference) == len(played) == 101
    assert reference == played
    assert abs(reference[-1][HEADLINE[model]]) > 1.0


def table(text):
    """Rows by name; true and false as numbers. The importer's own time column may be rounded differently."""
    number = {"true": 1.0, "false": 0.0}
    rows = csv.DictReader(io.StringIO(text))
    return [{name: number[cell] if cell in number else float(cell) for name, cell in row.items() if name != "time"} for row in rows]


@pytest.mark.parametrize(
    ("platform", "message"),
    [
        # No command here makes a library for macOS, so there is none to be found.
        ("x86_64-darwin" if sys.platform != "darwin" else "x86_64-windows", "cargo xtask cross"),
        ("win64", "x86_64-windows"),
    ],
)
def test_a_platform_without_a_library_is_reported_in_one_sentence(platform, message, motor_fmu, tmp_path):
    done = motor_fmu("build", "--platform", platform, "--out", tmp_path / "dist")
    assert done.returncode == 2 and not (tmp_path / "dist").exists()
    assert platform in done.stderr and message in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_build_says_what_its_libraries_need(motor_fmu, tmp_path):
    done = motor_fmu("build", "--fmi", "2", "--out", tmp_path / "dist")
    assert done.returncode == 0, done.stderr
    pattern = r"libraries for \S+-linux with glibc 2\.\d+ or later" if sys.platform == "linux" else "libraries for "
    assert re.match(pattern, done.stdout), done.stdout


def classified(files):
    """Metadata of an archive: keyword and value by classification."""
    root = ElementTree.fromstring(files["extra/org.ssp-standard.ssp-traceability.srmd/resourceMetaData.srmd"])
    space = "http://ssp-standard.org/SSPTraceability1/"
    assert root.tag == f"{{{space}SimulationResourceMetaData}}SimulationResourceMetaData"
    assert re.fullmatch(r"[0-9]+[.][0-9]+([.][0-9]+)?", root.get("version")) and root.get("name") and "motor-fmu" in root.get("generationTool")
    common = f"{{{space}SSPTraceabilityCommon}}"
    kinds = [element.get("type") for element in root]
    assert len(kinds) == len(set(kinds)) and {element.tag for element in root} == {common + "Classification"}
    return {e.get("type"): {entry.get("keyword"): entry.text for entry in e.iter(common + "ClassificationEntry")} for e in root}


def test_the_metadata_say_what_the_archive_is_made_of(packed):
    model, _, _, files = packed
    found = classified(files)
    assert found["motor-fmu.model"]["model"] == model
    assert found["motor-fmu.model"]["token"] in files["modelDescription.xml"].decode()
    assert found["motor-fmu.model"]["preset"].startswith("none")
    if model.endswith("otor"):
        assert found["motor-fmu.validity"]["validity.lowest_temperature"].startswith("100 K; ")


def test_the_metadata_follow_the_schema_of_the_specification(packed):
    resources = Path(pyssp_standard.__file__).parent / "resources"
    schema = xmlschema.XMLSchema11(resources / "SRMD11.xsd")
    files = packed[3]
    text = files["extra/org.ssp-standard.ssp-traceability.srmd/resourceMetaData.srmd"].decode()
    assert [error.reason for error in schema.iter_errors(text)] == []
    assert list(schema.iter_errors(text.replace("ClassificationEntry", "ClassificationItem")))


@pytest.mark.parametrize("fmi", STANDARDS)
def test_the_metadata_have_the_values_of_the_preset_with_their_sources(fmi):
    with zipfile.ZipFile(paths.dist() / "presets" / "maxon-305015" / f"fmi{fmi}" / "AnnulusCooledMotor.fmu") as archive:
        found = classified({name: archive.read(name) for name in archive.namelist()})
    assert found["motor-fmu.model"]["preset"] == "maxon-305015"
    assert found["motor-fmu.start-values"]["motor.R_ref"].startswith("0.386 Ohm; datasheet: terminal resistance")
    assert found["motor-fmu.validity"]["thermal.T_w_max"].startswith("428.15 K; ")
