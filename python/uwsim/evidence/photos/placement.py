"""Where a model lies in the world: its scale, the direction up, and its place, from positions or from its cameras."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from uwsim.base.texts.csv_table import CsvTable, read_csv
from uwsim.evidence.photos.reconstruction import Floats, Reconstruction

LEVEL_SHARE = 0.1
"""The cameras' horizontals give the vertical if they turn by at least this share of all directions."""
OUTLIER = 4.0
"""A position is left out beyond so many median residuals."""
COLUMNS = {
    "name": ("name", "image", "picture", "file", "filename", "label"),
    "x": ("x_m", "x", "east", "easting", "e"),
    "y": ("y_m", "y", "north", "northing", "n"),
    "z": ("z_m", "z", "up", "altitude", "height"),
    "depth": ("depth_m", "depth"),
}
STEADY_M = 1e-6


@dataclass(frozen=True)
class Placement:
    """scale: metres per unit. turn: (3, 3), from the model's axes to east, north, up. shift_m: of its origin.

    has_place: whether heights are above the water's surface.
    """

    scale: float
    turn: Floats
    shift_m: Floats
    has_place: bool
    notes: list[str]

    def turned(self, vectors: Floats) -> Floats:
        """Return vectors (n, 3) of the model in metres along the world's axes."""
        return np.asarray(self.scale * vectors @ self.turn.T)

    def placed(self, points: Floats) -> Floats:
        """Return points (n, 3) of the model in the world [m]."""
        return self.turned(points) + self.shift_m


class Similarity(NamedTuple):
    """The similarity that maps points to others best."""

    scale: float
    turn: Floats
    shift: Floats


def similarity(points: Floats, others: Floats) -> Similarity:
    """Return the similarity of least squares from points (n, 3) to others (Umeyama 1991, IEEE TPAMI 13:376)."""
    middle, other = points.mean(axis=0), others.mean(axis=0)
    u, s, v = np.linalg.svd((others - other).T @ (points - middle))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ v))])
    turn = u @ np.diag(signs) @ v
    scale = float((s * signs).sum() / ((points - middle) ** 2).sum())
    return Similarity(scale, turn, other - scale * turn @ middle)


def place(model: Reconstruction, *, scale: float | None, positions: Path | None) -> Placement:
    """Return a model's placement. Raises ValueError."""
    if positions is not None:
        if scale is not None:
            raise ValueError("--scale: must be left out with --positions, which state it")
        return _by_positions(model, positions)
    up, note = _up(model)
    notes = [note]
    if scale is None:
        notes.append("assumed: one unit of the model is 1 m, since it has no scale of its own: --scale or --positions")
    notes.append("assumed: north, since the model has none of its own: --positions states it")
    return Placement(scale or 1.0, _upright(up), np.zeros(3), False, notes)


def _upright(up: Floats) -> Floats:
    """Return the rotation that maps a direction to z, with the model's x kept as near to east as can be."""
    east = np.eye(3)[int(np.argmin(np.abs(up)))]
    east = east - (east @ up) * up
    east /= np.linalg.norm(east)
    return np.stack([east, np.cross(up, east), up])


def _up(model: Reconstruction) -> tuple[Floats, str]:
    """Return the direction up, and how it was found.

    Cameras of a vehicle that does not roll have their x axes level, so up is across all of them, if their headings
    differ. Otherwise up is across the plane that fits the points best. It is the side on which the cameras are.
    """
    points = model.points - np.median(model.points, axis=0)
    points = points[np.linalg.norm(points, axis=1) < 4.0 * np.median(np.linalg.norm(points, axis=1))]
    plane = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    x_axes = model.turns[:, :, 0]
    shares, axes = np.linalg.eigh(x_axes.T @ x_axes / len(x_axes))
    cameras = axes[:, 0]
    above = (model.centres - np.median(model.points, axis=0)).mean(axis=0)
    plane, cameras = (each if each @ above >= 0.0 else -each for each in (plane, cameras))
    apart = np.degrees(np.arccos(np.clip(plane @ cameras, -1.0, 1.0)))
    if shares[1] >= LEVEL_SHARE and len(x_axes) >= 3:
        roll = np.degrees(np.sqrt(max(shares[0], 0.0)))
        return cameras, (
            f"assumed: up is across the cameras' horizontals, which are {roll:.1f} deg (rms) off level to "
            f"it; the plane through the points is {apart:.1f} deg off"
        )
    return plane, (
        f"assumed: up is across the plane through the points, since the cameras' headings differ too "
        f"little; their horizontals would say {apart:.1f} deg off"
    )


def _by_positions(model: Reconstruction, file: Path) -> Placement:
    table = read_csv(file, f"'{file}'")
    names = table.texts(_column(table, file, "name"))
    down = next((each for each in table.columns if each.lower() in COLUMNS["depth"]), None)
    height = -table.numbers(down) if down is not None else table.numbers(_column(table, file, "z"))
    found = np.column_stack(
        [table.numbers(_column(table, file, "x")), table.numbers(_column(table, file, "y")), height]
    )
    stated = {Path(name).stem.lower(): k for k, name in enumerate(names)}
    own = [k for k, name in enumerate(model.pictures) if Path(name).stem.lower() in stated]
    others = np.array([stated[Path(model.pictures[k]).stem.lower()] for k in own], int)
    if len(own) < 3:
        raise ValueError(
            f"--positions '{file}': has {len(own)} of the {len(model.pictures)} pictures: must have 3 or "
            "more, by their names"
        )
    a, b = model.centres[own], found[others]
    fit = similarity(a, b)
    off = np.linalg.norm(fit.scale * a @ fit.turn.T + fit.shift - b, axis=1)
    kept = off <= OUTLIER * np.median(off) + STEADY_M
    if kept.sum() >= 3:
        fit = similarity(a[kept], b[kept])
    spread = np.linalg.svd(a[kept] - a[kept].mean(axis=0), compute_uv=False)
    if not (len(spread) > 1 and spread[1] > 1e-3 * spread[0] and fit.scale > 0.0):
        raise ValueError(
            f"--positions '{file}': the pictures were taken on a line, about which the model could turn: "
            "must have positions off it, or --scale"
        )
    off = np.linalg.norm(fit.scale * a[kept] @ fit.turn.T + fit.shift - b[kept], axis=1)
    lost = f", {len(own) - kept.sum()} left out as outliers" if not kept.all() else ""
    note = (
        f"read: '{file}': positions of {kept.sum()} pictures{lost}: {fit.scale:.5g} m per unit of the model, "
        f"{np.sqrt((off**2).mean()):.3g} m apart (rms), {off.max():.3g} m at most"
    )
    return Placement(fit.scale, fit.turn, fit.shift, True, [note])


def _column(table: CsvTable, file: Path, what: str) -> str:
    found = next((each for each in table.columns if each.lower() in COLUMNS[what]), None)
    if found is None:
        raise ValueError(
            f"--positions '{file}': has no column for {what}, such as '{COLUMNS[what][0]}': it has "
            f"{', '.join(table.columns)}"
        )
    return found
