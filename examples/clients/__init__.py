"""Clients of the motor FMU: a thin FMI wrapper, a gait load, a series elastic actuator and a fixed-step master.

The examples and the tests both import from here, so that what is tested is what people copy.
"""
