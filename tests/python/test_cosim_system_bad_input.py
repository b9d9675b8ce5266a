"""Invalid systems through the `motor-fmu` program: exit code 2 and one sentence. All cases: `tools/cosim/tests/system_faults.rs`."""

import pytest
from clients import paths
from test_cli_bad_input import CANNOT, one_sentence


def described(connect, components=("a", "b"), model="AnnulusCooledMotor", extra=""):
    head = f'[system]\nname = "bad"\nconnect = [{", ".join(map(repr, connect))}]\n'
    parts = (f'[[component]]\nname = "{name}"\nfmu = "{paths.archive(model, 2)}"\n' for name in components)
    return head + "".join(parts) + extra


@pytest.fixture
def cosim(motor_fmu, tmp_path):
    """Runs a system of this text."""

    def run(text, *arguments, command="cosim"):
        (tmp_path / "s.toml").write_text(text)
        return motor_fmu(command, "s.toml", *arguments)

    return run


def test_good_input_is_fine(cosim):
    done = cosim(described(["a.shaft_speed -> b.imposed_speed"]), "--stop", "0.01")
    assert done.returncode == 0, done.stderr
    # Unconnected inputs are listed.
    assert done.stderr.startswith("note: a: voltage, ") and "imposed_speed" not in done.stderr.splitlines()[1]


@pytest.mark.parametrize("command", ["cosim", "ssp"])
@pytest.mark.parametrize(
    "connection, words",
    [
        ("a.shaft_sped -> b.imposed_speed", ["a has no variable shaft_sped", "did you mean shaft_speed"]),
        ("c.shaft_speed -> b.imposed_speed", ["there is no component c"]),
        ("a.shaft_speed -> b.load_torque", ["a.shaft_speed is in rad/s", "b.load_torque in N.m", "cannot be converted"]),
        ("a.over_temperature -> b.voltage", ["a.over_temperature is Boolean", "b.voltage is Real"]),
        ("a.shaft_speed -> b.current", ["both ends are outputs"]),
        ("a.winding_margin -> a.heat_power", ["a.winding_margin is in K", "a.heat_power in W"]),
    ],
)
def test_connections(cosim, command, connection, words):
    one_sentence(cosim(described([connection]), command=command), CANNOT, "s.toml, line 3", f"connection {connection}", *words)


def test_an_algebraic_loop_is_named(cosim):
    loop = ["a.shaft_speed -> b.imposed_speed", "b.shaft_speed -> a.imposed_speed"]
    # A free shaft does not follow the imposed speed: the loop is open.
    free = cosim(described(loop), "--stop", "0.01")
    assert free.returncode == 0 and "does not react to its inputs" in free.stderr
    # An imposed speed is shown at once.
    imposed = [part for name in "ab" for part in ("--set", f"{name}.mechanical_mode=imposed_speed")]
    done = cosim(described(loop), *imposed)
    done.stderr = "\n".join(line for line in done.stderr.splitlines() if not line.startswith("note: "))
    one_sentence(
        done,
        CANNOT,
        "algebraic loop",
        "the gain around the loop is 1",
        "a.shaft_speed -> b.imposed_speed",
        "b.shaft_speed -> a.imposed_speed",
    )


def test_two_sources(cosim):
    twice = ["a.shaft_speed -> b.imposed_speed", "b.shaft_angle -> b.imposed_speed"]
    one_sentence(cosim(described(twice)), CANNOT, "b.imposed_speed has a source already", "a.shaft_speed -> b.imposed_speed")


def test_a_step_that_is_refused(cosim):
    hot = described(["a.winding_temperature -> b.ambient_temperature"], extra="[component.set]\n")
    done = cosim(hot, "--set", "a.heat_power=100000", "--stop", "1", "--step", "0.01")
    lines = [line for line in done.stderr.splitlines() if not line.startswith("note: ")]
    assert done.returncode == CANNOT and len(lines) == 1
    assert "of b returned Discard" in lines[0] and "ambient_temperature" in lines[0], lines[0]


@pytest.mark.parametrize(
    "text, words",
    [
        ('[system]\nname = "x"\n', ["s.toml, line 1", "there are no components"]),
        ('[system]\nname = "x"\n[[component]]\nname = "a"\nfmu = "none.fmu"\n', ["s.toml, line 4", "component a", "none.fmu"]),
        ('[system]\nname = "x"\nconnections = []\n', ["s.toml, line 3", "connections", "connect"]),
        ("[system\n", ["s.toml, line 1"]),
    ],
)
def test_descriptions(cosim, text, words):
    one_sentence(cosim(text), CANNOT, *words)


def test_archives_that_are_none(motor_fmu, tmp_path):
    (tmp_path / "text.ssp").write_text("hello")
    one_sentence(motor_fmu("cosim", "text.ssp"), CANNOT, "text.ssp is not a usable SSP archive")
    one_sentence(motor_fmu("cosim", "none.ssp"), CANNOT, "none.ssp")
    one_sentence(motor_fmu("ssp", "none.toml"), CANNOT, "none.toml")


def test_an_archive_is_not_written_over_its_own_source(motor_fmu, tmp_path):
    (tmp_path / "x.ssp").write_text("hello")
    one_sentence(motor_fmu("ssp", "x.ssp"), CANNOT, "x.ssp", "--out")


def test_settings(cosim):
    good = described(["a.shaft_speed -> b.imposed_speed"])
    one_sentence(cosim(good, "--set", "c.voltage=1"), CANNOT, "c.voltage = 1")
    one_sentence(cosim(good, "--set", "a.motor.R_ref=-1"), CANNOT, "motor.R_ref", "-1")
    one_sentence(cosim(good, "--tolerance", "2"), CANNOT, "tolerance = 2")
    one_sentence(cosim(good, "--step", "0"), CANNOT, "step size = 0 s")
