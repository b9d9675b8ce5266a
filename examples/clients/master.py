"""A fixed-step master for one FMU with a controller in Python, made for a million steps.

fmpy's own methods build new C arrays for every call. Here the arrays are made once and the C functions are called
directly, which leaves a few microseconds per step, most of them in the controller.
"""

import sys
import time
from ctypes import POINTER, byref, c_bool, c_double, c_int, c_size_t, c_uint, c_void_p, memmove

import numpy as np
from fmpy.fmi1 import FMICallException

from clients.fmu import FmuError, Instance

STATUS_WARNING = 1


class _Ports:
    """Preallocated arrays and calls for some inputs and outputs of an instance."""

    def __init__(self, instance: Instance, inputs, outputs, step: float):
        references = [(c_uint * len(names))(*map(instance.reference, names)) for names in (inputs, outputs)]
        self.u, self.y = (c_double * len(inputs))(), (c_double * len(outputs))()
        array, reference, component = POINTER(c_double), POINTER(c_uint), c_void_p(instance.slave.component)
        if instance.archive.version == "2.0":
            names, counts, kinds = ("fmi2SetReal", "fmi2GetReal", "fmi2DoStep"), [(), ()], (c_int,)
            rest = (0,)
        else:
            names = ("fmi3SetFloat64", "fmi3GetFloat64", "fmi3DoStep")
            counts = [(len(inputs),), (len(outputs),)]
            flags, reached = [c_bool() for _ in range(3)], c_double()
            kinds = (c_bool, *[POINTER(c_bool)] * 3, array)
            rest = (False, *map(byref, flags), byref(reached))

        def function(name, *kinds):
            # Indexing the library gives a function of our own, whose argument types fmpy does not share.
            function = instance.slave.dll[name]
            function.argtypes, function.restype = (c_void_p, *kinds), c_int
            return function

        value = [(reference, c_size_t, array, *[c_size_t] * len(count)) for count in counts]
        set_, get, do_step = function(names[0], *value[0]), function(names[1], *value[1]), function(names[2], c_double, c_double, *kinds)
        (u_refs, y_refs), u, y, (u_count, y_count) = references, self.u, self.y, counts

        def check(name, status):
            if status > STATUS_WARNING:
                raise FmuError(FMICallException(name, status), instance.lines[-1:])

        def send():
            check(names[0], set_(component, u_refs, len(u), u, *u_count))

        def advance(point):
            check(names[2], do_step(component, point, step, *rest))

        def receive():
            check(names[1], get(component, y_refs, len(y), y, *y_count))

        self.send, self.advance, self.receive = send, advance, receive


def run(instance: Instance, control, inputs, outputs, step: float, steps: int, stop=None, label: str = "") -> np.ndarray:
    """Runs `steps` steps and returns a record with one row per communication point: outputs, then inputs.

    `control(k, y)` gives the inputs of step k from the outputs `y` at its start; they are held over it. The run
    ends early where `stop(y)` is true. The last row has no inputs (nan). `label` names the run in the progress
    line, which is shown on a terminal only.
    """
    ports = _Ports(instance, inputs, outputs, step)
    record = np.full((steps + 1, len(outputs) + len(inputs)), np.nan)
    row, size_y, size_u, stride = record.ctypes.data, len(outputs) * 8, len(inputs) * 8, record.strides[0]
    u, y = ports.u, ports.y
    start, bar = instance.time, _Progress(label, steps)
    ports.receive()
    for k in range(steps):
        u[:] = control(k, y)
        memmove(row, y, size_y)
        memmove(row + size_y, u, size_u)
        row += stride
        ports.send()
        ports.advance(start + k * step)
        ports.receive()
        if stop is not None and stop(y):
            steps = k + 1
            break
        if not k & 0x3FFF:
            bar.show(k)
    memmove(row, y, size_y)
    instance.time = start + steps * step
    bar.close()
    return record[: steps + 1]


class _Progress:
    """One line on a terminal; silent elsewhere, so that logs stay readable."""

    def __init__(self, label: str, steps: int):
        self._label, self._steps, self._begin, self._on = label, steps, time.monotonic(), sys.stderr.isatty()

    def show(self, k: int):
        if self._on:
            print(f"\r{self._label} {100 * k // self._steps:3d} %", end="", file=sys.stderr, flush=True)

    def close(self):
        if self._on:
            print(f"\r{self._label} done in {time.monotonic() - self._begin:.1f} s", file=sys.stderr)
