"""One Model Exchange instance of an FMI 2.0 or 3.0 archive, with access by variable name."""

from ctypes import c_double
from math import prod

from clients.fmu import Archive
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model


def width(variable) -> int:
    """How many elements a variable has, by the start values of its description."""
    return prod(variable.shape) if variable.shape else 1


def elements(variables):
    """Each variable with the indices of its elements."""
    return [(variable, k) for variable in variables for k in range(width(variable))]


class Exchanged:
    """An instance in continuous-time mode, or in event mode if `event` is set. The interface is the same for both standards."""

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
        self.count = description.numberOfContinuousStates
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
        """The result of an event update: states changed, next event known, its time."""
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
        """Real values by name; the elements of an array are consecutive."""
        references = [self.reference(name) for name in names]
        if self.two:
            return self.model.getReal(references)
        return self.model.getFloat64(references, nValues=sum(width(self.archive.variable(name)) for name in names))

    def derivative(self, unknowns, known, element: int = 0) -> list[float]:
        """Partial derivatives of variables by name with respect to one variable or one element of an array."""
        seed = [0.0] * width(self.archive.variable(known))
        seed[element] = 1.0
        return self.along(unknowns, [known], seed)

    def along(self, unknowns, knowns, seed) -> list[float]:
        """Directional derivatives of variables by name, with one seed per element."""
        references = [self.reference(name) for name in unknowns], [self.reference(name) for name in knowns]
        more = {} if self.two else {"nSensitivity": sum(width(self.archive.variable(name)) for name in unknowns)}
        return self.model.getDirectionalDerivative(*references, seed, **more)

    def states(self) -> list[float]:
        """The continuous states."""
        x = (c_double * self.count)()
        self.model.getContinuousStates(x, self.count)
        return list(x)

    def put(self, states, time: float | None = None):
        """Sets the states, and the time if given."""
        if time is not None:
            self.model.setTime(time)
        self.model.setContinuousStates((c_double * self.count)(*states), self.count)

    def rates(self) -> list[float]:
        """The derivatives of the states."""
        rates = (c_double * self.count)()
        read = self.model.getDerivatives if self.two else self.model.getContinuousStateDerivatives
        read(rates, self.count)
        return list(rates)
