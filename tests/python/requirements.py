"""Which packages `requirements.txt` demands on this platform. A test that needs one of them fails where it is missing."""

from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def _demanded():
    lines = (Path(__file__).parent / "requirements.txt").read_text().splitlines()
    wanted = [Requirement(line) for line in lines if line.strip() and not line.startswith("#")]
    return {canonicalize_name(r.name) for r in wanted if r.marker is None or r.marker.evaluate()}


DEMANDED = _demanded()


def is_demanded(package):
    """Whether this platform and this Python have the package by requirements.txt."""
    return canonicalize_name(package) in DEMANDED


def where_demanded(package):
    """The mark of a test that needs a package which not every platform has."""
    return pytest.mark.skipif(not is_demanded(package), reason=f"requirements.txt has no {package} for this platform")
