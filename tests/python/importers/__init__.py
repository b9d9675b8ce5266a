"""Importers of other projects with one interface: an archive and a drive in, output rows out.

A drive is a communication step, parameters, and the inputs at every communication point. Inputs are set before a step and
held over it; the rows are what the outputs are after initialisation and after each step. Each importer runs in a process of
its own (`python -m importers NAME ARCHIVE DRIVE.json ROWS.json`), so that one that crashes is a finding and no end of the tests.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class Drive:
    """Step, parameters and inputs of a run. `inputs` has a value for each step; `outputs` are the names to read."""

    step: float
    parameters: dict[str, float]
    inputs: dict[str, list[float]]
    outputs: list[str]

    @property
    def steps(self) -> int:
        return len(next(iter(self.inputs.values())))

    def at(self, k: int) -> dict[str, float]:
        """The inputs that hold from point `k` on."""
        return {name: values[k] for name, values in self.inputs.items()}

    def write(self, path: Path):
        path.write_text(json.dumps(asdict(self)))

    @staticmethod
    def read(path: Path) -> "Drive":
        return Drive(**json.loads(path.read_text()))
