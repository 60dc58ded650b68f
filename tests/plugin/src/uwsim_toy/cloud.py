"""The format `.csv` of point clouds."""

import io

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.formats import CloudFormat, begins


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Return a line of x, y and z for each point, below their names."""
    text = io.StringIO()
    np.savetxt(text, points_m, "%.9g", ",", header="x,y,z", comments="")
    return text.getvalue().encode()


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points, (n, 3)."""
    return np.loadtxt(io.BytesIO(data), delimiter=",", skiprows=1, ndmin=2)


CSV = CloudFormat("CSV file", begins(rb"x,y,z\n"), decode, encode=encode)
