"""FMI 3 Co-Simulation with fmpy's master: events, early return, intermediate update."""

import math

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive
from fmpy import simulate_fmu
from fmpy.fmi3 import FMU3Slave
from test_model_exchange import CURRENT, FRICTION, GEARMOTOR, IMPOSED, MOTOR

# At stall, with 20 A: the winding passes its limit after some seconds.
HEATING = {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 20.0, "thermal.T_w_max": 340.0}
NAMES = ["winding_temperature", "winding_margin", "over_temperature", "current"]


def run(model, start, stop, interval, events, early, **options):
    return simulate_fmu(
        str(paths.archive(model, 3)),
        fmi_type="CoSimulation",
        start_values=start,
        stop_time=stop,
        output_interval=interval,
        use_event_mode=events,
        early_return_allowed=early,
        **options,
    )


def test_the_limit_ends_a_step():
    plain = run(MOTOR, HEATING, 40.0, 2.0, False, False, output=NAMES)
    result = run(MOTOR, HEATING, 40.0, 2.0, True, True, output=NAMES)
    hot = result["over_temperature"].astype(bool)
    first = int(np.argmax(hot))
    assert hot[first:].all() and not hot[:first].any() and 0 < first < len(hot) - 1
    # The step ends at the limit, found to a millionth of it; the flag turns there, at the event.
    time = result["time"]
    assert time[first - 1] == time[first] and abs(time[first] / 2.0 - round(time[first] / 2.0)) > 1e-3, "between two samples"
    assert -1e-4 < result["winding_margin"][first] <= 0.0
    # The rest is as without.
    ends = [k for k, t in enumerate(time) if math.isclose(t / 2.0, round(t / 2.0), abs_tol=1e-9)]
    assert [round(t / 2.0) for t in time[ends]] == list(range(21))
    rise = np.ptp(plain["winding_temperature"])
    assert np.abs(result["winding_temperature"][ends] - plain["winding_temperature"]).max() < 1e-8 * rise


def test_without_early_return_the_flag_waits_for_the_end_of_the_step():
    plain = run(MOTOR, HEATING, 40.0, 2.0, False, False, output=NAMES)
    result = run(MOTOR, HEATING, 40.0, 2.0, True, False, output=NAMES)
    first = int(np.argmax(result["over_temperature"]))
    assert result["time"][first - 1] == result["time"][first], "before and after the event"
    kept = np.delete(result, first - 1)
    for name in NAMES:
        assert kept[name].tobytes() == plain[name].tobytes()


@pytest.mark.parametrize(
    ("model", "start"),
    [(MOTOR, {"voltage": 24.0, "load_torque": 0.05, **FRICTION}), (GEARMOTOR, {"duty": 0.7, "load_torque": 0.3})],
)
def test_without_events_all_masters_read_the_same_bits(model, start):
    plain = run(model, start, 0.2, 1e-3, False, False)
    for early in (False, True):
        assert run(model, start, 0.2, 1e-3, True, early).tobytes() == plain.tobytes()


def test_magnets_lose_strength_at_their_time():
    start = {"voltage": 24.0, "effect.demagnetisation.fraction": 0.2, "effect.demagnetisation.time": 0.0337, **FRICTION}
    names = ["torque_constant", "shaft_speed"]
    result = run(MOTOR, start, 0.1, 1e-2, True, True, output=names)
    plain = run(MOTOR, start, 0.1, 1e-2, False, False, output=names)
    at = np.flatnonzero(np.isclose(result["time"], 0.0337, rtol=0.0, atol=1e-12))
    assert len(at) == 2, "reached, and after the event"
    assert result["torque_constant"][at[1]] < 0.81 * result["torque_constant"][0]
    assert result["shaft_speed"][-1] == pytest.approx(plain["shaft_speed"][-1], rel=1e-9)


class Looking:
    """An instance of the motor whose outputs are read at the intermediate updates."""

    def __init__(self, archive, early=False, until=None):
        self.archive, self.until, self.seen = archive, until, []
        self.slave = FMU3Slave(
            guid=archive.description.guid,
            modelIdentifier=archive.description.coSimulation.modelIdentifier,
            unzipDirectory=archive.folder,
            instanceName="looking",
        )
        self.named = [archive.variable(name).valueReference for name in ("shaft_speed", "T_housing")]
        self.slave.instantiate(earlyReturnAllowed=early, intermediateUpdate=self.look, requiredIntermediateVariables=self.named)
        self.slave.setFloat64([archive.variable("voltage").valueReference], [24.0])
        self.slave.enterInitializationMode(startTime=0.0)
        self.slave.exitInitializationMode()

    def look(self, _environment, time, _sets, gets, finished, may_return, requested, until):
        speed, *housing = self.slave.getFloat64(self.named, nValues=9)
        slope = self.slave.getOutputDerivatives(self.named[:1], [1])[0]
        self.seen.append((time, speed, slope, len(housing), gets and finished, may_return))
        if self.until is not None:
            requested[0], until[0] = True, self.until


def test_an_importer_looks_into_steps():
    with Archive(paths.archive(MOTOR, 3, "maxon-305015")) as archive, archive.instance() as plain:
        looking = Looking(archive)
        assert looking.slave.doStep(0.0, 0.02) == (False, False, False, 0.02)
        times, speeds, slopes, widths, given, may = zip(*looking.seen)
        assert times == pytest.approx([0.005, 0.01, 0.015, 0.02], rel=1e-15)
        assert set(widths) == {8} and all(given) and not any(may)
        plain.initialise({"voltage": 24.0})
        for speed in speeds:
            plain.step(0.005)
            assert plain.get("shaft_speed")[0] == pytest.approx(speed, rel=1e-12)
        assert slopes[0] > slopes[1] > slopes[2] > slopes[3] > 0.0, "it runs up"
        looking.slave.freeInstance()


@pytest.mark.parametrize(("until", "end"), [(0.0, 0.005), (0.0125, 0.0125), (0.0199, 0.0199)])
def test_an_importer_ends_a_step(until, end):
    with Archive(paths.archive(MOTOR, 3)) as archive:
        looking = Looking(archive, early=True, until=until)
        event, terminate, early, reached = looking.slave.doStep(0.0, 0.02)
        assert (event, terminate, early) == (False, False, True)
        assert reached == pytest.approx(end, rel=1e-14) and looking.seen[0][-1]
        looking.slave.freeInstance()
