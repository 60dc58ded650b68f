"""Reads grids of currents in metres of the world, and the numbers of CSV files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.npz import read_npz
from uwsim.base.texts.csv_table import read_csv
from uwsim.scenario.read.errors import ScenarioError


def is_ocean(path: Path) -> bool:
    """Return whether a file is an ocean model's field, in latitude and longitude, rather than one in metres."""
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError:
        return False
    return head[:3] == b"CDF" or head[:4] == b"\x89HDF" or b"latitude" in head


def read_current_grid(path: Path) -> tuple[Floats, ...]:
    """Read axes x, y, z (metres, ascending) and velocity (nz, ny, nx, 3) from .npz or CSV.

    A .npz may have t_s, which is returned last, and velocity (nt, nz, ny, nx, 3). Raises ScenarioError.
    """
    if path.suffix.lower() == ".npz":
        keys = ("x_m", "y_m", "z_m", "velocity_m_s")
        try:
            held = read_npz(path)
            arrays = [held[key] for key in (*keys, *(("t_s",) if "t_s" in held else ()))]
            if any(array.dtype.kind not in "iuf" for array in arrays):
                raise ValueError("arrays must hold real numbers")
            grid = tuple(np.asarray(array, np.float64) for array in arrays)
        except (ValueError, OSError, KeyError) as error:
            raise ScenarioError(f"current '{path}': not a .npz file with {', '.join(keys)}: {error}") from None
        return grid
    names, rows = csv_rows(path)
    columns = ("x_m", "y_m", "z_m", "u_m_s", "v_m_s", "w_m_s")
    if set(names) != set(columns):
        raise ScenarioError(f"current '{path}': columns are {', '.join(names)}: must be {', '.join(columns)}")
    table = rows[:, [names.index(column) for column in columns]]
    axes = [np.unique(table[:, k], return_inverse=True) for k in range(3)]
    (x_m, i), (y_m, j), (z_m, k) = axes
    velocity = np.full((len(z_m), len(y_m), len(x_m), 3), np.nan)
    velocity[k, j, i] = table[:, 3:]
    holes = int(np.isnan(velocity[..., 0]).sum())
    if holes or velocity[..., 0].size != len(table):
        raise ScenarioError(
            f"current '{path}': {len(table)} rows for {len(x_m)} x {len(y_m)} x {len(z_m)} points: must be one for each"
        )
    return x_m, y_m, z_m, velocity


def csv_rows(path: Path) -> tuple[list[str], Floats]:
    """Return the column names and the rows (n, columns). Raises ScenarioError."""
    try:
        table = read_csv(path)
        return list(table.columns), np.column_stack([table.numbers(column) for column in table.columns])
    except ValueError as error:
        raise ScenarioError(str(error)) from None
