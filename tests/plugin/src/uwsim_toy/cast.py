"""Casts of a probe whose files begin with its name, above depths [m] and temperatures [deg C]."""

from pathlib import Path

import numpy as np

from uwsim.base.reader import Reader
from uwsim.scenario.read.cast_levels import Columns


def read(path: Path, name: str) -> Columns:
    """Return the columns. name: of the file, for messages."""
    depth_m, temperature_deg_c = np.loadtxt(path, skiprows=1, unpack=True)
    return Columns({"depth_m": depth_m, "temperature_deg_c": temperature_deg_c}, [], [])


PROBE = Reader("a toy probe's cast", lambda path, head: head.startswith(b"TOYPROBE"), read)
