"""One Co-Simulation instance of an FMI 2.0 or 3.0 archive, addressed by variable name.

fmpy's two classes differ in the names of their methods and in value types; here both standards look alike,
and a call that the FMU refuses raises `FmuError` with the message that the FMU logged.
"""

import shutil
import tempfile
from ctypes import byref
from pathlib import Path
from typing import NamedTuple

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Slave
from fmpy.logging import addLoggerProxy

# The accessor of a variable's value, by its type in the XML. FMI 2 passes enumerations as integers, FMI 3 as Int64.
_ACCESSORS = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": {"2.0": "Integer", "3.0": "Int64"},
    "Boolean": "Boolean",
    "Float64": "Float64",
    "Int32": "Int32",
    "UInt64": "UInt64",
    "Int64": "Int64",
}


class LogLine(NamedTuple):
    """What an FMU said through its logger."""

    status: int
    category: str
    text: str


class FmuError(RuntimeError):
    """A call that the FMU refused: its name, the status it returned, and the log lines that came with it.

    A failed instantiation has neither name nor status, because fmpy reports neither."""

    def __init__(self, call: Exception, lines: list[LogLine]):
        self.function, self.status, self.lines = getattr(call, "function", None), getattr(call, "status", None), lines
        super().__init__(f"{call} {' '.join(line.text for line in lines)}".strip())


class _Fmi2Logger:
    """fmpy's formatting proxy keeps one logger for the whole process, so all FMI 2 instances share this one."""

    def __init__(self):
        self.sinks = {}
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        self.callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self.callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(byref(self.callbacks))

    def _log(self, _environment, name, status, category, message):
        self.sinks.get(name, []).append(LogLine(status, (category or b"").decode(), (message or b"").decode()))


_fmi2_logger = _Fmi2Logger()


class Archive:
    """An unzipped .fmu file. Use as a context manager: the folder is removed at the end."""

    def __init__(self, path):
        self.path = Path(path)
        self.description = fmpy.read_model_description(str(path))
        self.version = self.description.fmiVersion[:3]
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.folder = tempfile.mkdtemp(prefix="motor-fmu-")
        fmpy.extract(str(path), self.folder)
        self._count = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    def variable(self, name: str):
        """The declaration of a variable."""
        try:
            return self.variables[name]
        except KeyError:
            raise KeyError(f"{self.path.name} has no variable {name!r}") from None

    def instance(self) -> "Instance":
        """A new instance; several may live side by side."""
        self._count += 1
        return Instance(self, f"instance-{self._count}-of-{Path(self.folder).name}")


class Instance:
    """A Co-Simulation instance. Every method that the FMU refuses raises `FmuError`."""

    def __init__(self, archive: Archive, name: str):
        description = archive.description
        self.archive, self.name, self.lines, self.time = archive, name, [], 0.0
        arguments = dict(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=archive.folder,
            instanceName=name,
        )
        two = archive.version == "2.0"
        self.slave = FMU2Slave(**arguments) if two else FMU3Slave(**arguments)
        if two:
            _fmi2_logger.sinks[name.encode()] = self.lines
        try:
            self.slave.instantiate(loggingOn=True, **({"callbacks": _fmi2_logger.callbacks} if two else {"logMessage": self._log3}))
        except Exception as error:
            raise FmuError(error, self.lines) from None

    def _log3(self, _environment, status, category, message):
        self.lines.append(LogLine(status, (category or b"").decode(), (message or b"").decode()))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Frees the instance."""
        self.slave.freeInstance()
        _fmi2_logger.sinks.pop(self.name.encode(), None)

    def _call(self, method: str, *arguments, **options):
        first = len(self.lines)
        try:
            return getattr(self.slave, method)(*arguments, **options)
        except FMICallException as error:
            raise FmuError(error, self.lines[first:]) from None

    def _accessor(self, name: str) -> str:
        accessor = _ACCESSORS[self.archive.variable(name).type]
        return accessor if isinstance(accessor, str) else accessor[self.archive.version]

    def _value(self, name: str, value):
        """A value as the FMU takes it: an item of an enumeration may be given by its name."""
        if not isinstance(value, str):
            return value
        items = {item.name: int(item.value) for item in self.archive.variable(name).declaredType.items}
        if value not in items:
            raise ValueError(f"{name} = {value!r}; it takes {', '.join(items)}")
        return items[value]

    def set(self, values: dict):
        """Sets variables by name, in the order given."""
        for name, value in values.items():
            self._call(f"set{self._accessor(name)}", [self.reference(name)], [self._value(name, value)])

    def get(self, *names: str) -> list:
        """Values by name; of an array (FMI 3) a list of its elements."""
        return [self._read(name) for name in names]

    def _read(self, name: str):
        getter, dimensions = f"get{self._accessor(name)}", self.archive.variable(name).dimensions
        if not dimensions:
            return self._call(getter, [self.reference(name)])[0]
        count = 1
        for size in dimensions:
            count *= int(size.start) if size.start else self._call("getUInt64", [size.valueReference])[0]
        return self._call(getter, [self.reference(name)], nValues=count)

    def reference(self, name: str) -> int:
        """The value reference of a variable."""
        return self.archive.variable(name).valueReference

    def initialise(self, start: dict | None = None, time: float = 0.0, stop: float | None = None) -> "Instance":
        """From instantiated to step mode, with start values by name. Structural parameters (FMI 3) have a mode of their own."""
        start = start or {}
        sizes = {name: value for name, value in start.items() if self.archive.variable(name).causality == "structuralParameter"}
        if sizes:
            self._call("enterConfigurationMode")
            self.set(sizes)
            self._call("exitConfigurationMode")
        self.set({name: value for name, value in start.items() if name not in sizes})
        if self.archive.version == "2.0":
            self._call("setupExperiment", startTime=time, stopTime=stop)
            self._call("enterInitializationMode")
        else:
            self._call("enterInitializationMode", startTime=time, stopTime=stop)
        self._call("exitInitializationMode")
        self.time = time
        return self

    def slopes(self, values: dict):
        """Slopes of inputs for the next step, by name (FMI 2)."""
        references = [self.reference(name) for name in values]
        self._call("setRealInputDerivatives", references, [1] * len(references), list(values.values()))

    def step(self, size: float, point: float | None = None):
        """One communication step, from the instance's own time unless another point is given."""
        self._call("doStep", self.time if point is None else point, size)
        self.time += size

    def reset(self):
        """Back to instantiated, with the values of the XML."""
        self._call("reset")
        self.time = 0.0

    def state(self):
        """A copy of the state, with the time it belongs to."""
        return self._call("getFMUState"), self.time

    def restore(self, saved):
        """Goes back to a copy of the state."""
        self._call("setFMUState", saved[0])
        self.time = saved[1]

    def free(self, saved):
        """Gives back the memory of a copy of the state."""
        self._call("freeFMUState", saved[0])

    def serialise(self, saved) -> bytes:
        """A copy of the state as bytes."""
        return self._call("serializeFMUState", saved[0])

    def deserialise(self, data: bytes, time: float):
        """A copy of the state from bytes."""
        return self._call("deserializeFMUState", data), time
