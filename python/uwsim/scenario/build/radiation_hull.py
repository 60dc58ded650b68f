"""Compares a table of radiation and diffraction with the hull that it is given for, as it floats upright."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.axes import AXES
from uwsim.scenario.read.radiation_table import RadiationTable, broken_file

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAME_VOLUME, SAME_DENSITY, SAME_PRESSURE = 0.03, 0.05, 0.1
"""Largest relative differences between a table and its hull: volume under water, density, waves' pressure on it."""
PROBES = (0.3, 1.0)
"""Wave number times half the hull's length at which the waves' pressure is compared."""
DIVISIONS = 4
"""A hull in waves is cut into 1, 2, 4 or 8 slices."""
SMALL = 1e-3
"""Amplitude of waves whose force is computed, relative to the hull's half length."""
PANEL_SHARE = 0.06
"""Size of the triangles over which it is integrated, relative to the hull's length."""


LONGEST = 0.3
"""The same that the longest waves must reach where only the whole force is given."""
Panels = tuple[Array, Array, Array]
"""Centres (n, 3), outward normals (n, 3) and areas (n,) of a hull under water."""


class UprightHull(NamedTuple):
    """A hull that floats upright. waterline_m: height of the surface in the body frame."""

    vertices_m: Array
    triangles: NDArray[np.uint32]
    waterline_m: float
    wet_volume_m3: float
    half_length_m: float


def floating_upright(
    path: Path,
    mass_kg: float,
    vertices_m: Array,
    triangles: NDArray[np.uint32],
    density_kg_m3: float,
) -> UprightHull:
    """Find how deep the hull floats upright."""
    craft = _core.Craft(_unit_inertia(mass_kg, vertices_m), vertices_m, triangles)
    wanted = mass_kg / density_kg_m3
    if wanted >= craft.volume_m3:
        raise broken_file(
            path,
            f"the hull does not float: {mass_kg:.4g} kg is more than the "
            f"{density_kg_m3 * craft.volume_m3:.4g} kg of water that it displaces",
        )
    low, high = (float(edge) for edge in (vertices_m[:, 2].min(), vertices_m[:, 2].max()))
    for _ in range(60):
        level = 0.5 * (low + high)
        state = _core.BodyState((0.0, 0.0, -level), (0.0, 0.0, 0.0, 1.0), np.zeros(6))
        if craft.submerged_fraction(state) * craft.volume_m3 < wanted:
            low = level
        else:
            high = level
    half_m = 0.5 * float(np.ptp(vertices_m[:, :2], axis=0).max())
    return UprightHull(vertices_m, triangles, 0.5 * (low + high), wanted, half_m)


def require_same_hull(
    path: Path, table: RadiationTable, hull: UprightHull, mass_kg: float, density_kg_m3: float
) -> None:
    """Raise ScenarioError unless the table is of this hull: density, displacement, the undisturbed waves' force."""
    if not table.of_any_density and abs(table.density_kg_m3 / density_kg_m3 - 1.0) > SAME_DENSITY:
        raise broken_file(
            path,
            f"rho = {table.density_kg_m3:.5g} kg/m3: must be within {SAME_DENSITY:.0%} of the scenario's water, "
            f"{density_kg_m3:.5g} kg/m3",
        )
    if table.displaced_kg is not None:
        volume = table.displaced_kg / table.density_kg_m3
        if abs(volume / hull.wet_volume_m3 - 1.0) > SAME_VOLUME:
            raise broken_file(
                path,
                f"displaces {volume:.4g} m3: this hull of {mass_kg:.4g} kg displaces {hull.wet_volume_m3:.4g} m3, must "
                f"be within {SAME_VOLUME:.0%}; another hull, or another mass",
            )
    panels, half_m = _wet_panels(hull), hull.half_length_m
    number = table.omega_rad_s**2 / table.gravity_m_s2
    if table.froude_krylov is None:
        _require_same_long_waves(path, table, float(number[0] * half_m), panels)
        return
    for row in {int(np.argmin(np.abs(number * half_m - probe))) for probe in PROBES}:
        if number[row] * min(table.water_depth_m, 1e9) < 3.0:
            continue  # shallow water: its dispersion would be needed
        for column in (0, len(table.heading_rad) // 2):
            own = _pressure_force(table, table.omega_rad_s[row], table.heading_rad[column], panels)
            given = table.froude_krylov[row, column]
            scale = np.abs(own[:3]).max() * np.array([1.0, 1.0, 1.0, half_m, half_m, half_m])
            off = np.abs(given - own) / scale
            if off.max() > SAME_PRESSURE:
                axis = int(off.argmax())
                name = AXES[axis]
                raise broken_file(
                    path,
                    f"Froude_Krylov_force in {name} at {table.omega_rad_s[row]:.3g} rad/s differs by {off[axis]:.0%} "
                    f"of the largest force from that on this hull, must be within {SAME_PRESSURE:.0%}: another hull, "
                    "or its frame is not x forward from the vehicle's origin and z up from the waterline",
                )


def _require_same_long_waves(path: Path, table: RadiationTable, number_of_half_length: float, panels: Panels) -> None:
    """Compare the whole force in heave in the longest waves with the pressure and the relative motion's added mass."""
    if number_of_half_length > LONGEST:
        raise broken_file(
            path,
            f"has neither the undisturbed waves' force (.3fk, froude-krylov) nor waves long enough to compare: "
            f"wave number times half its length is {number_of_half_length:.2g} at least, must reach {LONGEST:g}",
        )
    omega = table.omega_rad_s[0]
    own = _pressure_force(table, omega, table.heading_rad[0], panels)[2] - omega**2 * table.added_mass[0, 2, 2]
    off = abs(table.exciting[0, 0, 2] / own - 1.0)
    if off > SAME_PRESSURE:
        raise broken_file(
            path,
            f"the waves' force in heave at {omega:.3g} rad/s differs by {off:.0%} from this hull's, must be within "
            f"{SAME_PRESSURE:.0%}: another hull",
        )


def pressure_forces(table: RadiationTable, hull: UprightHull) -> Complex:
    """Return the force of the undisturbed waves' pressure as a step computes it, in water as the table has it.

    Complex (divisions of the hull into slices, frequencies, headings, 6), about the table's centre, per metre of
    amplitude, of exp(-i omega t): half the difference between opposite phases, for waves of SMALL of its half length.
    """
    water = _core.Water()
    water.density_kg_m3, water.gravity_m_s2 = table.density_kg_m3, table.gravity_m_s2
    at_rest = _core.BodyState((0.0, 0.0, -hull.waterline_m), (0.0, 0.0, 0.0, 1.0), np.zeros(6))
    amplitude_m = SMALL * hull.half_length_m
    own = _unit_inertia(1.0, hull.vertices_m)
    crafts = [_core.Craft(own, hull.vertices_m, hull.triangles, division) for division in range(DIVISIONS)]
    found = np.empty((DIVISIONS, len(table.omega_rad_s), len(table.heading_rad), 6), np.complex128)
    for row, omega in enumerate(table.omega_rad_s):
        quarter_s = 0.5 * np.pi / omega
        for column, heading in enumerate(table.heading_rad):
            water.waves = _core.Waves.airy(
                amplitude_m, 4.0 * quarter_s, heading, depth_m=table.water_depth_m, gravity_m_s2=table.gravity_m_s2
            )
            for division, craft in enumerate(crafts):
                moved = [craft.acceleration_body(at_rest, np.zeros(6), water, k * quarter_s) for k in range(4)]
                found[division, row, column] = moved[0] - moved[2] + 1j * (moved[1] - moved[3])
    linear, turning = found[..., :3] / (2.0 * amplitude_m), found[..., 3:] / (2.0 * amplitude_m)
    middle_m = np.asarray(own.centre_of_mass_body_m)
    force = linear + np.cross(turning, middle_m)
    at = middle_m - table.centre_m - (0.0, 0.0, hull.waterline_m)
    return np.concatenate([force, turning + np.cross(at, force)], axis=-1)


def _unit_inertia(mass_kg: float, vertices_m: Array) -> _core.CraftParameters:
    """Return a rigid body without drag and added mass, of a unit moment of inertia about the middle of its box."""
    own = _core.CraftParameters()
    own.mass_kg, own.inertia_kg_m2 = mass_kg, np.eye(3)
    own.centre_of_mass_body_m = 0.5 * (vertices_m.min(axis=0) + vertices_m.max(axis=0))
    return own


def _wet_panels(hull: UprightHull) -> Panels:
    """Return centres (n, 3) in the table's frame, outward normals (n, 3) and areas (n,) of the hull under water."""
    from uwsim.base.whole_trimesh import trimesh

    at = hull.vertices_m - [0.0, 0.0, hull.waterline_m]
    mesh = trimesh.Trimesh(at, hull.triangles, process=False)
    wet = trimesh.intersections.slice_mesh_plane(  # type: ignore[no-untyped-call]
        mesh, (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)
    )
    vertices, faces = trimesh.remesh.subdivide_to_size(  # type: ignore[no-untyped-call]
        wet.vertices, wet.faces, PANEL_SHARE * 2.0 * hull.half_length_m, max_iter=20
    )
    corners = np.asarray(vertices)[np.asarray(faces)]
    twice = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(twice, axis=1)
    kept = length > 0.0
    return corners.mean(axis=1)[kept], twice[kept] / length[kept, None], 0.5 * length[kept]


def _pressure_force(table: RadiationTable, omega_rad_s: float, heading_rad: float, panels: Panels) -> Complex:
    """Return force and moment about the table's centre of the undisturbed deep-water wave's pressure, complex (6,)."""
    centres, normals, areas = panels
    number = omega_rad_s**2 / table.gravity_m_s2
    along = centres[:, 0] * np.cos(heading_rad) + centres[:, 1] * np.sin(heading_rad)
    pressure = table.density_kg_m3 * table.gravity_m_s2 * np.exp(number * (centres[:, 2] + 1j * along))
    forces = -(pressure * areas)[:, None] * normals
    moments = np.cross(centres - table.centre_m, forces)
    return np.asarray(np.concatenate([forces.sum(axis=0), moments.sum(axis=0)]), np.complex128)
