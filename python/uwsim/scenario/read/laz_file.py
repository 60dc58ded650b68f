"""LAZ files: compressed LAS, also with COPC's octree. lazrs may panic on damaged ones, so a contained process reads."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.mapping.files import las
from uwsim.mapping.files.formats import CloudFormat, begins
from uwsim.scenario.read.contained import run_contained

PROCESS = Path(__file__).with_name("laz_process.py")


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points of a LAZ file of any version. Raises ValueError."""
    need_extra("lazrs", "a LAZ file")
    with tempfile.NamedTemporaryFile(suffix=".laz") as file:
        file.write(data)
        file.flush()
        return run_contained(PROCESS, "lazrs", file.name, reads=[Path(file.name)], cpu_s_per_byte=2e-6)["points"]


LAZ = CloudFormat(
    "LAZ file", begins(rb"LASF.{100}[\x80-\xff]"), decode,
    encode=partial(las.encode, compresses=True), encode_at=partial(las.encode_at, compresses=True),
)  # fmt: skip
