"""An integrator with a gain: the test exports it with pythonfmu (FMI 2)."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Integrator2(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y, self.u, self.gain = 0.0, 1.0, 1.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("gain", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, current_time, step_size):
        self.y += self.gain * self.u * step_size
        return True
