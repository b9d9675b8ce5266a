"""Runs checkers on an FMU: ours, and two others that are free."""

import functools
import json
import logging
import subprocess

import xmlschema
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU

# Reading a schema takes longer than checking a file with it.
xmlschema.XMLSchema = functools.cache(xmlschema.XMLSchema)

#: Seconds that a stage of the run may take, so that a hang is seen soon.
PATIENCE = 4


def ours(program, path):
    """The exit code, and the findings of `motor-fmu validate`."""
    command = [program, "validate", str(path), "--json", "--patience", str(PATIENCE)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if done.returncode == 2:
        return 2, []
    return done.returncode, json.loads(done.stdout)[0]["findings"]


def fmpy(path):
    """Whether `fmpy validate` finds anything."""
    try:
        return bool(validate_fmu(str(path)))
    except Exception:  # a checker that stumbles over the fault has noticed it
        return True


class _Count(logging.Handler):
    def __init__(self):
        super().__init__(logging.ERROR)
        self.count = 0

    def emit(self, record):
        self.count += 1


def fmutool(path):
    """Whether `fmutool -check` finds anything."""
    logger = logging.getLogger("fmu_manipulation_toolbox")
    count, kept = _Count(), logger.handlers[:]
    logger.handlers, logger.propagate = [count], False
    try:
        with FMU(str(path)) as fmu:
            for checker in get_checkers():
                fmu.apply_operation(checker())
    except Exception:  # as above
        return True
    finally:
        logger.handlers = kept
    return count.count > 0
