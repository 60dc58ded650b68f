"""The draft of a vehicle's file from a mesh alone. Every coefficient is an estimate, with its method and its spread."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.axes import AXES
from uwsim.exchange.hulls.draft_actuators import ACCELERATION_M_S2, Body, Thrust, proposed_fins, proposed_thrusters
from uwsim.exchange.hulls.hull_drag import hull_drag
from uwsim.scenario.build.hydrodynamics import COARSE, GIVEN_MAX, added_mass_by_steps
from uwsim.scenario.build.scale import METRES, likely_units, size_text
from uwsim.scenario.read.errors import RepairWarning, ScenarioError
from uwsim.scenario.read.mesh_file import Forward, Up, load_mesh, own_up, turned_to_x
from uwsim.scenario.read.mesh_repair import closed_mesh
from uwsim.scenario.spec.vehicle import DENSITIES_KG_M3

Floats = NDArray[np.float64]
DRIVEN = ("surge", "heave", "yaw")
FRESH_KG_M3 = 1000.0
LEVER = 0.1
"""Assumed depth of the centre of mass below the centre of buoyancy, relative to the hull's height."""
CRITICAL = 0.3
"""Assumed damping ratio of roll and pitch."""
SLOW_M_S, SETTLES_S = 0.1, 3.0
"""Linear drag equals quadratic drag at this speed; a turn without thrust settles in this time (assumed)."""
FAST_M_S = 1.0
SLIP_M_S, SLIP_SHORT_S = 0.5, 2.0
"""A side slip of SLIP_M_S that halves faster than SLIP_SHORT_S is not seen in a survey's curves."""
LONG_ALONG_Y = 1.5
"""Ratio of the lengths along y and x above which the bow is taken to be along y (assumed)."""
TALL = 1.2
"""Ratio of a hull's height to its longer side from which it may stand on its tail (assumed)."""
TRIMMED_KG_M3 = (500.0, 2000.0)
"""Mean densities of vehicles trimmed to float; others are asked about, since lengths are then off by 1.26 or more."""
DECLARED = (".glb", ".gltf", ".fbx", ".dae", ".step", ".stp")
"""Formats that declare their unit."""
LARGE_M = 5.0
"""Length from which a declared unit is asked about, too: few vehicles are longer (assumed)."""
MANY = 5000
"""Triangles from which the long steps are announced."""
FRAME = 0.6
"""Share of its convex hull below which a hull is one of plates, tubes or fins."""
CLOSED_SPREAD = "panels, within 2 % of ideal flow about this mesh"
FRAME_SPREAD = (
    "panels; it fills only {:.2g} of its convex hull: for five such, those published are 0.27 to 2.1 times theirs, "
    "6.3 times for roll with fins"
)
"""Measured on the meshes of RexROV (Berg 2012: 0.33 to 2.07 times, heave 0.53, pitch 0.33), BlueROV2 (Wu 2018: 0.27 to
2.07), BlueROV2 Heavy (von Benzon et al. 2022: 0.74 to 1.47), ECA A9 (of its published model: 0.97 to 1.88) and the
packaged REMUS 100 (Prestero 2001: 0.88 to 1.26, and 6.31 for roll)."""
THIN = 0.1
"""Share of its convex hull below which a hull may be a shell that was meant to be a solid (assumed)."""
NEGLIGIBLE, COUPLED = 1e-3, 0.999
"""NEGLIGIBLE: entries of the added mass smaller than this, relative to the body's mass and inertia, are left out, and
so are all entries of an axis whose own is. COUPLED: share of the couplings that is kept, so that the matrix stays
positive where it is rounded: that of a round hull beside its axis is singular."""


@dataclass(frozen=True)
class Draft:
    """A vehicle's file. text: YAML. notes: what was assumed about the mesh, one line each. doubts: what to check."""

    text: str
    notes: tuple[str, ...]
    doubts: tuple[str, ...] = ()


def drafted(
    mesh: Path,
    axes: Collection[str] | None = None,
    mass_kg: float | None = None,
    unit: str | None = None,
    forward: Forward | None = None,
    up: Up | None = None,
    length_m: float | None = None,
    progress: Callable[[str], object] = lambda text: None,
) -> Draft:
    """Return the draft of a vehicle with the hull of a mesh, whose thrusters drive `axes`.

    axes: by default DRIVEN, and sway for a blunt hull, whose side slip after a turn lasts. mass_kg: by default neutral.
    unit: of METRES; by default it is guessed from the mass or the length. length_m: of the longest side, instead.
    up: as for `load_mesh`. forward: the direction of the bow, with z up; by default x, or y for a hull that is
    LONG_ALONG_Y. progress: called with a line before each long step on a mesh of MANY triangles. The body's
    origin is the centroid of the hull. Raises
    ScenarioError.
    """
    from uwsim.base.whole_trimesh import trimesh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the check of the draft issues them again
        vertices, triangles = load_mesh(mesh, up=up)
    across = np.ptp(vertices[triangles].reshape(-1, 3), axis=0)
    doubts = list(_tall(across, up or own_up(mesh)))
    if forward is None and across[1] > LONG_ALONG_Y * across[0]:
        bow = f"it is {across[1] / across[0]:.2g} times as long along y as along x: the bow is taken to be along y"
        bow += "; --forward -y if it is its stern, x if it is its side"
        forward = "y"
    else:
        bow = f"its bow is taken to be along {forward or 'x'} ({'as given' if forward else 'the default'})"
    forward = forward or "x"
    if len(triangles) > MANY:
        progress(f"mesh '{mesh}': {len(triangles)} triangles are closed and united")

    def closed(scale: float) -> trimesh.Trimesh:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RepairWarning)  # as above
            scaled = turned_to_x(vertices * scale, forward)
            return trimesh.Trimesh(*closed_mesh(scaled, triangles, name=str(mesh)), process=False)

    longest = float(across.max())
    if length_m is not None:
        scale, why = float(f"{length_m / longest:.6g}"), f"of the length of {length_m:g} m, as given"
    elif unit is not None:
        scale, why = METRES[unit], f"{unit}, as given"
    elif mass_kg is not None:
        guess, reason = _unit_of_mass(mesh, float(closed(1.0).volume), mass_kg)
        scale, why = METRES[guess], f"{guess}, {reason}"
    else:
        scale, why = _unit_of_length(mesh, longest)
    solid = closed(scale)
    faces, size_m, volume_m3 = solid.faces, np.ptp(solid.vertices, axis=0), float(solid.volume)
    if mass_kg is None and unit is None and length_m is None:
        doubts += _other_units(mesh, longest, scale, volume_m3)
    elif mass_kg is not None and not TRIMMED_KG_M3[0] <= (density := mass_kg / volume_m3) <= TRIMMED_KG_M3[1]:
        at_m = np.cbrt(density / FRESH_KG_M3) * size_m.max()
        doubts.append(
            f"{mass_kg:g} kg make {density:.4g} kg/m3: it would be neutral if it were {at_m:.3g} m long, not "
            f"{size_m.max():.3g} m: state which by --length-m"
        )
    centroid_m = np.asarray(solid.center_mass)
    hull_m = np.asarray(solid.vertices) - centroid_m
    backward: Forward = {"y": "-y", "-y": "y"}.get(forward, forward)  # type: ignore[assignment]
    in_file = turned_to_x(centroid_m[None] / scale, backward)[0]
    notes = [
        f"its scale is {scale:g}, {why}: {size_text(size_m)}, {volume_m3:.4g} m3; --length-m states another",
        bow,
        f"the body's origin is the hull's centroid, ({_plain(np.round(in_file, 3))}) in the file",
    ]
    share = volume_m3 / float(solid.convex_hull.volume)
    if share < THIN:
        doubts.append(
            f"it encloses {share:.2g} of its convex hull: where it is a shell, only its sheet displaces water, and the "
            "draft is one of a very light vehicle; make it solid (in Blender: a Remesh modifier)"
        )
    if len(faces) > COARSE:
        simpler = f"by a thousandth of its size, or until {GIVEN_MAX} remain"
        notes.append(f"its {len(faces)} triangles are simplified for the added mass, {simpler}")
    if len(faces) > MANY:
        progress(f"mesh '{mesh}': its added mass is computed by panels")
    added, remedy = added_mass_by_steps(hull_m, faces, FRESH_KG_M3)
    if remedy:
        doubts.append(f"added mass: {remedy}")
    spread = FRAME_SPREAD.format(share) if share < FRAME else CLOSED_SPREAD
    how = f"{spread}; {remedy}" if remedy else spread
    body = _body(hull_m, faces, volume_m3, np.diagonal(solid.moment_inertia), mass_kg, added)
    if axes is None:
        half_s = slip_half_s(body)
        axes = (*DRIVEN, "sway") if half_s > SLIP_SHORT_S else DRIVEN
        slips = f"a side slip of {SLIP_M_S:g} m/s halves in {half_s:.1f} s"
        notes.append(f"its thrusters drive {', '.join(axis for axis in AXES if axis in axes)}, since {slips}; --axes")
    placed = _mesh_lines(mesh, scale, why, up, forward)
    text = "\n".join(_lines(mesh, placed, body, how, proposed_thrusters(body, axes), mass_kg))
    of_mesh = f"mesh '{mesh}': "
    return Draft(text + "\n", tuple(of_mesh + note for note in notes), tuple(of_mesh + doubt for doubt in doubts))


def slip_half_s(body: Body) -> float:
    """Return the time in which a side slip of SLIP_M_S falls to half, m dv/dt = -(a + b v) v with both drags."""
    mass_kg, b = body.mass_kg + float(body.added[1, 1]), float(body.quadratic[1])
    a, v = SLOW_M_S * b, SLIP_M_S
    return float(mass_kg / a * np.log((2.0 * a + b * v) / (a + b * v)))


def _tall(across: Floats, up: Up) -> Iterator[str]:
    """Yield a question about a hull that may stand on its tail."""
    if across[2] > TALL * max(across[:2]):
        first, second = (axis for axis in "xyz" if axis != up[-1])
        yield (
            f"it is {across[2] / max(across[:2]):.2g} times as high as long: where it stands on its tail, name the "
            f"file's axis that points up, --up {first} or --up {second} (or -{first}, -{second}), not {up}"
        )


def _unit_of_mass(mesh: Path, volume: float, mass_kg: float) -> tuple[str, str]:
    """Return the unit in which a mesh of this volume fits a mass, and the reason."""
    off = {unit: abs(np.log(mass_kg / (volume * metres**3) / FRESH_KG_M3)) for unit, metres in METRES.items()}
    unit = min(off, key=lambda each: off[each])
    low, high = DENSITIES_KG_M3
    if low <= (density := mass_kg / (volume * METRES[unit] ** 3)) <= high:
        return unit, f"with which {mass_kg:g} kg makes {density:.4g} kg/m3"
    raise ScenarioError(f"mesh '{mesh}': no unit makes {mass_kg:g} kg a plausible mass: check it, or give --length-m")


def _unit_of_length(mesh: Path, longest: float) -> tuple[float, str]:
    """Return the metres of the likeliest unit of a mesh, and the reason."""
    units = likely_units(longest)
    if not units:
        raise ScenarioError(f"mesh '{mesh}': is {longest:.4g} long: no unit makes that a vehicle's length; give --unit")
    return METRES[units[0]], f"{units[0]}, guessed from its length of {longest:.4g}"


def _other_units(mesh: Path, longest: float, scale: float, volume_m3: float) -> Iterator[str]:
    """Yield a question about a mesh whose format declares no unit, and which other units would fit."""
    units = likely_units(longest)[1:]
    if mesh.suffix.lower() in DECLARED:
        units = []
        if longest * scale <= LARGE_M:
            return
    elif not units:
        return
    fits = [(METRES[unit], f"in {unit}") for unit in units]
    each = [
        f"{longest * metres:.3g} m long and {FRESH_KG_M3 * volume_m3 * (metres / scale) ** 3:.3g} kg {label}"
        for metres, label in [(scale, "as taken"), *fits]
    ]
    yield f"its unit is a guess: neutral, it is {', '.join(each)}: state --unit, --length-m or --mass-kg"


def _body(
    hull_m: Floats,
    triangles: NDArray[np.integer],
    volume_m3: float,
    moments_m5: Floats,
    mass_kg: float | None,
    added: Floats,
) -> Body:
    mass = FRESH_KG_M3 * volume_m3 if mass_kg is None else mass_kg
    drag = hull_drag(hull_m, triangles, FRESH_KG_M3, FAST_M_S)
    quadratic = drag.bluff.copy()
    quadratic[0] = drag.streamlined + drag.flat_share * (drag.bluff[0] - drag.streamlined)
    return Body(
        low_m=hull_m.min(axis=0),
        high_m=hull_m.max(axis=0),
        mass_kg=mass,
        inertia_kg_m2=mass / volume_m3 * moments_m5,
        added=added,
        quadratic=quadratic,
        surge_spread=(drag.streamlined, float(drag.bluff[0])),
        munk_share=1.0 - drag.flat_share,
        lever_m=LEVER * float(np.ptp(hull_m[:, 2])),
        density_kg_m3=FRESH_KG_M3,
    )


def _lines(
    mesh: Path, placed: Sequence[str], body: Body, added_how: str, thrusters: Sequence[Thrust], mass_kg: float | None
) -> Iterator[str]:
    size_m, low, high = body.high_m - body.low_m, body.low_m, body.high_m
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", mesh.stem).strip("_")
    yield f"# Drafted by `uwsim vehicle {mesh.name} --draft`. Estimates unless a line states otherwise."
    yield "# Six-vectors: surge, sway, heave, roll, pitch, yaw. Body frame: x forward, y left, z up."
    yield f"name: {(name if name[:1].isalpha() else 'hull_' + name)[:40]}"
    yield from placed
    yield "centre_of_buoyancy_m: [0, 0, 0]   # moves the mesh, so that the origin is the hull's centroid"
    yield ("buoyancy: neutral   # assumed" if mass_kg is None else f"mass_kg: {mass_kg:g}   # given")
    yield f"centre_of_mass_m: [0, 0, {-body.lever_m:.4g}]   # estimated by {LEVER:g} of the hull's height"
    inertia = "estimated by a solid of uniform density (0.7 to 1.5 times)"
    yield f"inertia_kg_m2: [{_plain(body.inertia_kg_m2)}]   # {inertia}"
    yield f"added_mass_matrix:   # {added_how}"
    for axis, row in zip(AXES, written(body), strict=True):
        yield f"  - [{_plain(row)}]   # {axis}: estimated by ideal flow"
    yield f"munk_share: {body.munk_share:.2g}   # estimated by the share of the frontal area that is not flat (0 to 1)"
    yield from _drag_lines(body)
    yield f"crossflow_length_m: {size_m[0]:.4g}   # estimated by the hull's length"
    yield "thrusters:   # proposed for the axes asked for; gain: estimated by drag and the accelerations below"
    for each in thrusters:
        yield f"  {each.name}: {{model: t200_16v, position_m: [{_plain(each.position_m)}], axis: [{_plain(each.axis)}],"
        yield f"    spin: {each.spin}, gain: {each.gain:.2g}}}"
    fins = proposed_fins(body)
    if fins:
        yield "fins:   # proposed, fixed: estimated by the area that cancels the Munk moment"
    for fin in fins:
        yield f"  {fin.name}: {{position_m: [{_plain(fin.position_m)}], span: [{_plain(fin.span)}],"
        yield f"    area_m2: {fin.area_m2:.3g}, aspect_ratio: {fin.aspect_ratio:g}, parasitic_drag: 0.01}}"
    yield "control:   # gains: the defaults; limits: proposed"
    yield f"  acceleration_max_m_s2: {ACCELERATION_M_S2:g}"
    yield f"  turn_acceleration_max_rad_s2: {body.turn_acceleration_rad_s2:.2g}"
    yield f"  turn_max_rad_s: {body.turn_rad_s:.2g}"
    yield f"sonar: {{position_m: [{_plain([0.9 * high[0], 0.0, low[2]])}]}}   # proposed: under the bow"
    yield "sensors:   # proposed; rates and errors as in the packaged sensors `bluerov2`"
    yield "  imu: {kind: imu, rate_hz: 200, channels: {angular_velocity: {density: 7.0e-5, turn_on_std: 1.0e-3},"
    yield "    linear_acceleration: {density: 9.8e-4, turn_on_std: 0.02}, orientation: {std: 1.0e-3}}}"
    yield "  depth: {kind: depth, rate_hz: 20, noise: {std: 0.005, quantum: 0.002}}"
    yield f"  altitude: {{kind: altitude, position_m: [{_plain([0.0, 0.0, low[2]])}], rate_hz: 15, range_max_m: 100,"
    yield "    noise: {std: 0.0024}}"
    yield f"  dvl: {{kind: dvl, position_m: [{_plain([0.5 * low[0], 0.0, low[2]])}], rate_hz: 5, range_max_m: 50,"
    yield "    channels: {beam_velocity: {std: 0.01}, beam_range: {std: 0.05}}}"
    yield "  compass: {kind: compass, rate_hz: 50, noise: {std: 0.005}}"


def _mesh_lines(mesh: Path, scale: float, unit: str, up: Up | None, forward: Forward) -> list[str]:
    lines = [f"mesh: {json.dumps(str(mesh.resolve()), ensure_ascii=False)}   # or relative to this file"]
    lines.append(f"mesh_scale: {scale:g}   # {unit}")
    if up is not None:
        lines.append(f"mesh_up: {up}   # the file's axis that points up")
    if forward != "x":
        lines.append(f"mesh_forward: {forward}   # the direction of the bow, seen with z up")
    return lines


def written(body: Body) -> Floats:
    """Return the added mass (6, 6) as the file states it."""
    own = np.array([*[body.mass_kg] * 3, *body.inertia_kg_m2])
    diagonal = np.diagonal(body.added)
    axes = diagonal >= NEGLIGIBLE * own
    kept = np.outer(axes, axes) & (np.abs(body.added) >= NEGLIGIBLE * np.sqrt(np.outer(own, own)))
    return np.where(kept, COUPLED * body.added + (1.0 - COUPLED) * np.diag(diagonal), 0.0)


def _drag_lines(body: Body) -> Iterator[str]:
    quadratic = body.quadratic
    low, high = body.surge_spread
    surge = (
        f"ITTC-57 friction with Hoerner's form factor, {low:.3g}, and a blunt body, {high:.3g}, by the bow's flat share"
    )
    strips = "strips (0.3 to 1.8 times; 0 if the hull is round about the axis)"
    yield "quadratic_damping:"
    yield from _by_axis(quadratic, [surge, *["C_D 1.1 (0.3 to 1.8 times)"] * 2, *[strips] * 3])
    turning = body.inertia_kg_m2 + np.diagonal(body.added)[3:]
    righting_nm_rad = body.mass_kg * _core.Water().gravity_m_s2 * body.lever_m
    rocking = 2.0 * CRITICAL * np.sqrt(righting_nm_rad * turning[:2])
    along = f"the quadratic drag at {SLOW_M_S:g} m/s (0.3 to 3 times)"
    about = f"{CRITICAL:g} of critical damping (assumed, 0.3 to 3 times)"
    yield "linear_damping:"
    yield from _by_axis(
        np.array([*(SLOW_M_S * quadratic[:3]), *rocking, turning[2] / SETTLES_S]),
        [*[along] * 3, *[about] * 2, f"settling in {SETTLES_S:g} s (assumed, 0.3 to 3 times)"],
    )


def _by_axis(values: Floats, methods: Sequence[str]) -> Iterator[str]:
    for axis, value, method in zip(AXES, values, methods, strict=True):
        yield f"  - {value:.4g}   # {axis}: estimated by {method}"


def _plain(values: Sequence[float] | Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in np.asarray(values, np.float64) + 0.0)
