"""An integrator with a gain: the test exports it with pythonfmu3 (FMI 3)."""

from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64


class Integrator3(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y, self.u, self.gain = 0.0, 1.0, 1.0
        self.register_variable(Float64("y", causality=Fmi3Causality.output))
        self.register_variable(Float64("u", causality=Fmi3Causality.input))
        self.register_variable(Float64("gain", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable))

    def do_step(self, current_time, step_size):
        self.y += self.gain * self.u * step_size
        return True
