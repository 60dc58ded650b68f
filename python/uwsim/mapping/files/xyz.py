"""XYZ files: plain text with one point per line, as x y z separated by spaces."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.formats import CloudFormat, begins
from uwsim.mapping.files.georeference import Georeference


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Encode points as an XYZ file, using the shortest decimals that read back as the same numbers."""
    texts = points_m.astype(str).tolist()
    return "".join(f"{x} {y} {z}\n" for x, y, z in texts).encode("ascii")


def encode_at(points_m: NDArray[np.floating], place: Georeference) -> bytes:
    """Encode points as longitude, latitude [deg, WGS 84] and height [m], to a millimetre."""
    latitude, longitude = place.degrees(points_m).T
    rows = zip(longitude.tolist(), latitude.tolist(), points_m[:, 2].tolist(), strict=True)
    return "".join(f"{x:.9f} {y:.9f} {z:.3f}\n" for x, y, z in rows).encode("ascii")


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points in the first three columns, separated by spaces, tabs or commas; # starts a comment."""
    text = io.StringIO(data.decode("ascii").replace(",", " "))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # numpy warns about an empty file
        return np.loadtxt(text, np.float64, usecols=(0, 1, 2), ndmin=2).reshape(-1, 3)


ROW = begins(rb"([ \t\r]*(#[^\n]*)?\n)*([ \t,]*([-+]?\.?\d[-+.\deE]*|(?i:nan))(?![^\s,#])){3}")
XYZ = CloudFormat("XYZ file", ROW, decode, encode=encode, text_mark=b"", encode_at=encode_at)
