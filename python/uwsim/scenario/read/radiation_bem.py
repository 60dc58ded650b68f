"""Reads tables of a floating hull's hydrodynamics that WAMIT writes, and the HDF5 that WEC-Sim's BEMIO makes of them.

Both are dimensionless (WAMIT, "User Manual", ch. 4; BEMIO's normalizeBEM.m): with the length L, which BEMIO leaves out,
and u = 1 for forces, L for moments,

  A = rho L^3 u_i u_j A',   B = rho omega L^3 u_i u_j B',   X = rho g L^2 u_i X',   D = rho g L u_i D'

so that they are valid for any density. Their forces are those of exp(+i omega t), the conjugates of Capytaine's.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.hdf5_file import inside_hdf5
from uwsim.scenario.read.radiation_table import MAX_VALUES, Array, Complex, RadiationTable, broken_file, table_of

MAX_BYTES = 200_000_000
RHO = 1000.0
"""The density [kg/m3] in which values are kept; the table is valid for any."""
SAME_PERIOD = 1e-5
DRIFTS = {".8": "momentum_conservation", ".7": "control_surface", ".9": "pressure_integration"}
"""WAMIT's mean drift, with BEMIO's names; the first that is there is read."""
DRIFT_MODES = (1, 2, 6)
HEADER = {
    "gravity": re.compile(r"Gravity:\s+([\d.Ee+-]+)"),
    "length": re.compile(r"Length scale:\s+([\d.Ee+-]+)"),
    "depth": re.compile(r"Water depth:\s+(\S+)"),
    "origin": re.compile(r"XBODY =\s*(\S+)\s+YBODY =\s*(\S+)\s+ZBODY =\s*(\S+)\s+PHIBODY =\s*(\S+)"),
    "volume": re.compile(r"Volumes \(VOLX,VOLY,VOLZ\):\s*(\S+)\s+(\S+)\s+(\S+)"),
}


def read_wamit(path: Path) -> RadiationTable:
    """Read NAME.1, and beside it NAME.3, NAME.out, and NAME.3fk, .8, .7 or .9 if there. Raises ScenarioError."""
    header = _header(path)
    gravity, length = float(header["gravity"][0]), float(header["length"][0])
    depth = header["depth"][0]
    *centre, turned = (float(each) for each in header["origin"])
    if turned != 0.0:
        raise broken_file(path, f"PHIBODY = {turned:g}: must be 0 deg")
    units = np.array([1.0, 1.0, 1.0, length, length, length])
    omega, mass, damping = _matrices(path)
    waves = np.where(np.isfinite(omega), omega, 0.0)[:, None, None]
    of_pair, of_wave = RHO * length**3 * np.multiply.outer(units, units), RHO * gravity * length**2 * units
    heading, exciting = _forces(path.with_suffix(".3"), omega)
    froude_krylov = None
    if path.with_suffix(".3fk").exists():
        same, froude_krylov = _forces(path.with_suffix(".3fk"), omega)
        if not np.array_equal(same, heading):
            raise broken_file(path.with_suffix(".3fk"), "its headings must be those of the file .3")
        froude_krylov = of_wave * froude_krylov
    drift = _drift(path, omega, heading)
    return table_of(
        path,
        omega,
        (of_pair * mass, of_pair * waves * damping),
        heading,
        (of_wave * exciting, froude_krylov),
        None if drift is None else RHO * gravity * length * np.array([1.0, 1.0, length]) * drift,
        centre_m=np.array(centre),
        density_kg_m3=RHO,
        gravity_m_s2=gravity,
        displaced_kg=RHO * float(np.median([float(each) for each in header["volume"]])),
        water_depth_m=np.inf if depth.lower().startswith("inf") else float(depth),
        of_any_density=True,
    )


def _header(path: Path) -> dict[str, tuple[str, ...]]:
    """Return what the file .out states of the run."""
    out = path.with_suffix(".out")
    if not out.exists():
        raise broken_file(path, f"'{out.name}' beside it missing: it has gravity, depth, frame and displacement")
    found: dict[str, tuple[str, ...]] = {}
    with out.open(errors="replace") as file:
        for line in file:
            for name, pattern in HEADER.items():
                if match := pattern.search(line):
                    if name == "origin" and name in found:
                        raise broken_file(out, "has more than one body: must be one")
                    found.setdefault(name, match.groups())
            if " Output from  WAMIT" in line or "Wave period" in line:
                break
    missing = [name for name in HEADER if name not in found]
    if missing:
        raise broken_file(out, f"{', '.join(missing)} missing: must be WAMIT's")
    return found


def _rows(path: Path, columns: tuple[int, ...]) -> list[list[float]]:
    """Return the numbers of each line, without titles. Raises ScenarioError."""
    if not path.exists():
        raise broken_file(path, "missing: must be beside the file .1")
    if path.stat().st_size > MAX_BYTES:
        raise broken_file(path, f"has {path.stat().st_size} bytes: must be at most {MAX_BYTES}")
    rows = []
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        words = line.split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            if number == 1:
                continue
            raise broken_file(path, f"line {number} must be numbers") from None
        if values and len(values) not in columns:
            raise broken_file(path, f"line {number} has {len(values)} values, must have {columns[-1]}")
        if values:
            rows.append(values)
    return rows


def _axis(path: Path, value: float) -> int:
    if not value.is_integer() or not 1 <= value <= 6:
        raise broken_file(path, f"mode {value:g}: must be 1 to 6, those of one rigid body")
    return int(value) - 1


def _omega(period: float) -> float:
    """Return the frequency of a period, of which WAMIT writes -1 for infinity."""
    return 0.0 if period < 0.0 else np.inf if period == 0.0 else 2.0 * np.pi / period


def _matrices(path: Path) -> tuple[Array, Array, Array]:
    """Return the frequencies, and added mass and damping of each. Raises ScenarioError."""
    rows = _rows(path, (4, 5))
    periods = list(dict.fromkeys(row[0] for row in rows))
    place = {period: k for k, period in enumerate(periods)}
    both = np.zeros((2, len(periods), 6, 6))
    for period, i, j, *values in rows:
        for kind, value in enumerate(values):
            both[kind, place[period], _axis(path, i), _axis(path, j)] = value
    return np.array([_omega(period) for period in periods]), both[0], both[1]


def _forces(path: Path, omega_rad_s: Array) -> tuple[Array, Complex]:
    """Return headings [rad] and the forces at each frequency; not a number at 0 and infinity. Raises ScenarioError."""
    values = [
        (period, heading, _axis(path, mode), real - 1j * imaginary)
        for period, heading, mode, _, _, real, imaginary in _rows(path, (7,))
    ]
    return _by_wave(path, omega_rad_s, values, 6)


def _drift(path: Path, omega_rad_s: Array, headings_rad: Array) -> Array | None:
    """Return the mean drift at each frequency and heading, None without a file. Raises ScenarioError."""
    given = [file for suffix in DRIFTS if (file := path.with_suffix(suffix)).exists()]
    if not given:
        return None
    values = [
        (period, heading, DRIFT_MODES.index(int(abs(mode))), complex(real))
        for period, heading, other, mode, _, _, real, _ in _rows(given[0], (8,))
        if heading == other and abs(mode) in DRIFT_MODES
    ]
    same, found = _by_wave(given[0], omega_rad_s, values, len(DRIFT_MODES))
    if not np.array_equal(same, headings_rad):
        raise broken_file(given[0], "its headings must be those of the file .3")
    return np.asarray(found.real, np.float64)


def _by_wave(
    path: Path, omega_rad_s: Array, values: list[tuple[float, float, int, complex]], modes: int
) -> tuple[Array, Complex]:
    """Return headings [rad] and an array (frequencies, headings, modes) of period, heading [deg], mode and value."""
    headings = sorted({value[1] for value in values})
    column = {heading: k for k, heading in enumerate(headings)}
    finite = np.isfinite(omega_rad_s) & (omega_rad_s > 0.0)
    missing = broken_file(path, "must have a force for each period of the file .1, heading and mode")
    if len(values) < np.count_nonzero(finite) * len(headings) * modes:
        raise missing  # before memory is taken for a file of many headings
    found = np.full((len(omega_rad_s), len(headings), modes), np.nan, np.complex128)
    for period, heading, mode, value in values:
        near = np.abs(omega_rad_s / _omega(period) - 1.0)
        if not near[finite].min(initial=1.0) <= SAME_PERIOD:
            raise broken_file(path, f"period {period:g} s is not in the file .1")
        found[np.nanargmin(near), column[heading], mode] = value
    if np.isnan(found[finite]).any():
        raise missing
    return np.radians(headings), found


def read_wec_sim(path: Path) -> RadiationTable:
    """Read the HDF5 that BEMIO writes, of one body. Raises ScenarioError."""
    with inside_hdf5(path, f"radiation '{path}', of WEC-Sim") as data:
        if data.has("body2"):
            raise broken_file(path, "has more than one body: must be one")

        def values(name: str) -> NDArray[Any]:
            if (found := data.dataset(name)) is None or (found.size or 0) > MAX_VALUES:
                raise broken_file(path, f"{name} missing: must be a file of WEC-Sim's BEMIO")
            return data.values(name, found)

        def numbers(name: str) -> Array:
            try:
                return np.asarray(values(name), np.float64)
            except (TypeError, ValueError):
                raise broken_file(path, f"{name} must be numbers") from None

        def force(name: str) -> Complex:
            """Return (frequencies, headings, 6); the file has them the other way round."""
            parts = [numbers(f"body1/hydro_coeffs/{name}/{part}") for part in ("re", "im")]
            if any(part.shape != (6, len(heading), len(omega)) for part in parts):
                raise broken_file(path, f"{name} must have 6 modes, {len(heading)} headings, {len(omega)} frequencies")
            return np.asarray((parts[0] - 1j * parts[1]).transpose(2, 1, 0), np.complex128)

        def matrices(name: str, shape: tuple[int, ...]) -> Array:
            found = numbers(f"body1/hydro_coeffs/{name}")
            if found.shape != shape:
                raise broken_file(path, f"{name} is of shape {found.shape}: must be {shape}")
            return found

        if str(values("simulation_parameters/scaled").ravel()[0]) not in ("0", "0.0", "False", "b'False'"):
            raise broken_file(path, "scaled must be 0: coefficients over density and gravity")
        omega = numbers("simulation_parameters/w").ravel()
        heading = np.radians(numbers("simulation_parameters/wave_dir").ravel())
        gravity = float(numbers("simulation_parameters/g").ravel()[0])
        depth = values("simulation_parameters/water_depth").ravel()[0]
        whole = (6, 6, len(omega))
        mass = RHO * matrices("added_mass/all", whole).transpose(2, 0, 1)
        infinite = RHO * matrices("added_mass/inf_freq", (6, 6))
        damping = RHO * omega[:, None, None] * matrices("radiation_damping/all", whole).transpose(2, 0, 1)
        parts = [RHO * gravity * force("excitation")]
        if data.has("body1/hydro_coeffs/excitation/froude-krylov/re"):
            parts.append(RHO * gravity * force("excitation/froude-krylov"))
        drift = None
        if given := [name for name in DRIFTS.values() if data.has(f"body1/hydro_coeffs/mean_drift/{name}/val")]:
            drift = numbers(f"body1/hydro_coeffs/mean_drift/{given[0]}/val")
            if drift.shape != (6, len(heading), len(omega)):
                raise broken_file(
                    path, f"mean_drift must have 6 modes, {len(heading)} headings, {len(omega)} frequencies"
                )
            drift = RHO * gravity * drift[[mode - 1 for mode in DRIFT_MODES]].transpose(2, 1, 0)
            drift = np.concatenate([drift, np.full_like(drift[:1], np.nan)])
        whole_force, *pressure = (np.concatenate([part, np.full_like(part[:1], np.nan)]) for part in parts)
        return table_of(
            path,
            np.append(omega, np.inf),
            (np.concatenate([mass, infinite[None]]), np.concatenate([damping, np.zeros((1, 6, 6))])),
            heading,
            (whole_force, pressure[0] if pressure and np.isfinite(parts[1]).all() else None),
            drift,
            centre_m=numbers("body1/properties/cg").ravel(),
            density_kg_m3=RHO,
            gravity_m_s2=gravity,
            displaced_kg=RHO * float(numbers("body1/properties/disp_vol").ravel()[0]),
            water_depth_m=float(depth) if np.issubdtype(type(depth), np.number) else np.inf,
            of_any_density=True,
        )
