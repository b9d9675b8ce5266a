"""ecos, a C++ engine for both standards, through ecospy."""

import ctypes
import sys
from pathlib import Path

from importers import Drive

# The engine needs oneTBB and does not look into the environment's own lib folder, where the package `tbb` puts it.
ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402


def record(path: Path, drive: Drive) -> list[list[float]]:
    def named(values):
        return {f"motor::{name}": value for name, value in values.items()}

    with EcosSimulationStructure() as structure:
        structure.add_model("motor", str(path))
        structure.add_parameter_set("start", named(drive.parameters | drive.at(0)))
        with EcosSimulation(structure=structure, step_size=drive.step) as simulation:
            assert simulation.init(parameter_set="start"), "ecos could not initialise the FMU"

            def read():
                return [simulation.get_real(f"motor::{name}") for name in drive.outputs]

            rows = [read()]
            for k in range(drive.steps):
                for name, value in named(drive.at(k)).items():
                    simulation.set_real(name, value)
                simulation.step()
                rows.append(read())
    return rows
