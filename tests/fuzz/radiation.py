"""Tables of a floating hull's hydrodynamics: readers for the fuzzers, and the small files with which these start."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

WAMIT_PARTS = (".1", ".out", ".3", ".8", ".3fk")
PAGE = b"\f"
"""Separates the files of one run of WAMIT in an input."""
OMEGA_RAD_S = np.array([1.0, 2.0, 3.0, 4.0])
HEADINGS_DEG = (0.0, 180.0)
DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
OUT = """ Gravity:     9.81000                Length scale:        1.00000
 Water depth:        infinite
 XBODY =    0.0000 YBODY =    0.0000 ZBODY =    0.0000 PHIBODY =   0.0
 Volumes (VOLX,VOLY,VOLZ):      0.480000    0.480000    0.480000
"""


def table(suffix: str) -> Callable[[bytes, Path], Any]:
    """Return a reader of one file."""

    def read(data: bytes, folder: Path) -> list[bytes]:
        path = folder / f"hull{suffix}"
        path.write_bytes(data)
        return _content(path)

    return read


def wamit(data: bytes, folder: Path) -> list[bytes]:
    """Read the files of one run: WAMIT_PARTS, each after a PAGE, the last of them not necessarily there."""
    parts = data.split(PAGE)[: len(WAMIT_PARTS)]
    for suffix in WAMIT_PARTS:
        (folder / f"hull{suffix}").unlink(missing_ok=True)
    for suffix, part in zip(WAMIT_PARTS, parts, strict=False):
        (folder / f"hull{suffix}").write_bytes(part)
    return _content(folder / "hull.1")


def _content(path: Path) -> list[bytes]:
    from uwsim.scenario.read.radiation_file import read_radiation

    found = read_radiation(path)
    arrays = (found.omega_rad_s, found.heading_rad, found.added_mass, found.damping, found.exciting, found.drift)
    return [b"" if array is None else array.tobytes() for array in arrays]


def capytaine() -> list[bytes]:
    """Return a dataset of Capytaine in classic NetCDF."""
    from scipy.io import netcdf_file

    count, headings = len(OMEGA_RAD_S) + 1, len(HEADINGS_DEG)
    sizes = {
        "omega": count,
        "wave_direction": headings,
        "influenced_dof": 6,
        "radiating_dof": 6,
        "complex": 2,
        "xyz": 3,
    }
    wave = ("complex", "omega", "wave_direction", "influenced_dof")
    arrays: dict[str, tuple[tuple[str, ...], Any]] = {
        "omega": (("omega",), np.append(OMEGA_RAD_S, np.inf)),
        "wave_direction": (("wave_direction",), np.radians(HEADINGS_DEG)),
        "rotation_center": (("xyz",), np.zeros(3)),
        "rho": ((), 1000.0),
        "g": ((), 9.81),
        **dict.fromkeys(("added_mass", "radiation_damping"), (("omega", "influenced_dof", "radiating_dof"), 1.0)),
        **dict.fromkeys(("diffraction_force", "Froude_Krylov_force"), (wave, 1.0)),
        **{f"drift_force_{name}": (("omega", "wave_direction"), 1.0) for name in ("surge", "sway", "yaw")},
    }
    file = io.BytesIO()
    with netcdf_file(file, "w") as data:
        for axis, size in {**sizes, "letters": 5}.items():
            data.createDimension(axis, size)
        for axis in ("influenced_dof", "radiating_dof"):
            data.createVariable(axis, "c", (axis, "letters"))[:] = [list(name.ljust(5)) for name in DOFS]
        for name, (axes, values) in arrays.items():
            data.createVariable(name, "d", axes)[...] = values
        data.flush()
        return [file.getvalue()]


def wamit_run() -> list[bytes]:
    """Return the files of one run, with and without those that need not be there."""
    pairs = [f"{i + 1} {j + 1}" for i, j in np.ndindex(6, 6)]
    periods = [f"{2.0 * np.pi / omega:.9e}" for omega in OMEGA_RAD_S]
    rows = [f" 0.0 {pair} 1.0" for pair in pairs] + [f" {p} {pair} 1.0 0.5" for p in periods for pair in pairs]
    forces = [f" {p} {h} {mode} 1 0 1.0 0.0" for p in periods for h in HEADINGS_DEG for mode in range(1, 7)]
    drifts = [f" {p} {h} {h} {mode} 1 0 1.0 0.0" for p in periods for h in HEADINGS_DEG for mode in (1, 2, 6)]
    texts = ["\n".join(rows), OUT, "\n".join(forces), "\n".join(drifts), "\n".join(forces)]
    return [PAGE.join(text.encode() for text in texts[:parts]) for parts in (3, 4, 5)]


def wec_sim() -> list[bytes]:
    """Return the HDF5 of BEMIO."""
    import h5py

    count, headings, body = len(OMEGA_RAD_S), len(HEADINGS_DEG), "body1/hydro_coeffs"
    wave = (6, headings, count)
    values: dict[str, Any] = {
        "simulation_parameters/scaled": [[0.0]],
        "simulation_parameters/g": [[9.81]],
        "simulation_parameters/w": OMEGA_RAD_S[:, None],
        "simulation_parameters/wave_dir": np.array(HEADINGS_DEG)[:, None],
        "simulation_parameters/water_depth": "infinite",
        "body1/properties/cg": np.zeros((3, 1)),
        "body1/properties/disp_vol": [[0.48]],
        f"{body}/added_mass/all": np.ones((6, 6, count)),
        f"{body}/added_mass/inf_freq": np.ones((6, 6)),
        f"{body}/radiation_damping/all": np.ones((6, 6, count)),
        f"{body}/excitation/re": np.ones(wave),
        f"{body}/excitation/im": np.ones(wave),
        f"{body}/mean_drift/control_surface/val": np.ones(wave),
    }
    file = io.BytesIO()
    with h5py.File(file, "w") as data:
        for name, value in values.items():
            data[name] = value
    return [file.getvalue()]
