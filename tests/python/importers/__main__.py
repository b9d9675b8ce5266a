"""`python -m importers NAME ARCHIVE DRIVE.json ROWS.json`: runs one importer and writes its rows with all digits."""

import importlib
import json
import sys
from pathlib import Path

from importers import Drive

name, archive, drive, rows = sys.argv[1:]
recorded = importlib.import_module(f"importers.with_{name}").record(Path(archive), Drive.read(Path(drive)))
# JSON from Python holds a float to the last bit.
Path(rows).write_text(json.dumps(recorded))
