"""One Model Exchange instance of an FMI 2.0 or 3.0 archive, addressed by variable name: what a solver sees of it."""

from ctypes import c_double

from clients.fmu import Archive
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model


class Exchanged:
    """An instance in continuous-time mode, or in event mode where `event` says so. Both standards look alike."""

    def __init__(self, archive: Archive, start: dict | None = None, event: bool = False):
        description = archive.description
        self.archive, self.two = archive, archive.version == "2.0"
        kind = FMU2Model if self.two else FMU3Model
        self.model = kind(
            guid=description.guid,
            modelIdentifier=description.modelExchange.modelIdentifier,
            unzipDirectory=archive.folder,
            instanceName="exchanged",
        )
        self.model.instantiate()
        self.count = len(description.derivatives)
        self.set(start or {})
        if self.two:
            self.model.setupExperiment(startTime=0.0)
        self.model.enterInitializationMode()
        self.model.exitInitializationMode()
        self.update()
        if not event:
            self.model.enterContinuousTimeMode()

    def close(self):
        """Frees the instance."""
        self.model.freeInstance()

    def update(self):
        """What an event brings: whether states changed, whether a next event is known, and when."""
        found = self.model.newDiscreteStates() if self.two else self.model.updateDiscreteStates()
        return tuple(found)[3:]

    def reference(self, name: str) -> int:
        """The value reference of a variable."""
        return self.archive.variable(name).valueReference

    def set(self, values: dict):
        """Sets variables by name; enumerations by their number."""
        for name, value in values.items():
            kind = {"Enumeration": "Integer" if self.two else "Int64"}.get(self.archive.variable(name).type)
            getattr(self.model, f"set{kind or self.archive.variable(name).type}")([self.reference(name)], [value])

    def get(self, names) -> list[float]:
        """Real values by name."""
        return getattr(self.model, "getReal" if self.two else "getFloat64")([self.reference(name) for name in names])

    def states(self) -> list[float]:
        """The continuous states."""
        x = (c_double * self.count)()
        self.model.getContinuousStates(x, self.count)
        return list(x)

    def put(self, states, time: float | None = None):
        """Puts the states, and the time where it is given."""
        if time is not None:
            self.model.setTime(time)
        self.model.setContinuousStates((c_double * self.count)(*states), self.count)

    def rates(self) -> list[float]:
        """The derivatives of the states."""
        rates = (c_double * self.count)()
        read = self.model.getDerivatives if self.two else self.model.getContinuousStateDerivatives
        read(rates, self.count)
        return list(rates)
