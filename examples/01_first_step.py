"""The shortest use of the motor FMU: 24 V on a free shaft for ten seconds.

Run `cargo xtask demo` first: it builds the archives and a Python environment with fmpy.
"""

import json

from clients.paths import archive
from fmpy import simulate_fmu

result = simulate_fmu(
    str(archive("AnnulusCooledMotor", fmi=3)),
    stop_time=10.0,
    output_interval=1e-3,
    start_values={"voltage": 24.0, "load_torque": 0.1},
    output=["shaft_speed", "current", "winding_temperature"],
)
print(json.dumps({name: float(result[name][-1]) for name in result.dtype.names}, indent=2))
