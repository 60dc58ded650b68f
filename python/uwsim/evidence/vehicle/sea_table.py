"""The table of radiation and diffraction of a floating hull's mesh, for `uwsim vehicle hull.stl --draft --sea`.

Capytaine (Ancellin and Dias 2019, J. Open Source Software 4:1341) solves for the hull's panels under water; it is not a
dependency. Two meshes are solved at a few frequencies, the second with two to four times as many panels, and their
difference is what the line of convergence states.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.atomic_file import write_atomically
from uwsim.scenario.build.potential_flow import simplified
from uwsim.scenario.build.radiation_hull import floating_upright
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import ScenarioError

Array = NDArray[np.float64]
COARSE_PANELS, FINE_PANELS = 350, 700
"""About how many there are under water."""
GIVEN_TRIANGLES = 300
"""A mesh is simplified to about as many before it is cut into panels."""
LEAST, MOST, FREQUENCIES = 0.06, 12.0, 28
"""Wave numbers times half the hull's length, from waves of 50 to one of a quarter of the length."""
COMPARED = (0.3, 1.0, 3.0, 8.0)
"""Likewise, where both meshes are solved."""
HEADINGS_DEG = np.arange(0.0, 181.0, 15.0)
KEPT = ["added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force", "disp_mass", "rotation_center"]
FLOATS = "--sea needs a hull that floats: give --mass-kg, less than what it displaces"


def write_sea_table(
    path: Path, hull_m: Array, triangles: NDArray[np.integer], mass_kg: float, centre_z_m: float, density_kg_m3: float
) -> str:
    """Write the table of a hull that floats upright, as NetCDF, and return the line of its convergence.

    hull_m (n, 3), triangles (m, 3): closed, body frame. centre_z_m: height of the centre of mass in it. The result is
    cached by all that it depends on. Raises ScenarioError if the hull does not float or Capytaine is missing.
    """
    faces = np.ascontiguousarray(triangles, np.uint32)
    if mass_kg >= density_kg_m3 * _core.solid_properties(hull_m, faces).volume_m3:
        raise ScenarioError(FLOATS)
    upright = floating_upright(path, mass_kg, hull_m, faces, density_kg_m3)
    centre_z_m -= upright.waterline_m
    points = hull_m - [0.0, 0.0, upright.waterline_m]

    def make() -> tuple[Array, NDArray[np.uint8]]:
        if find_spec("capytaine") is None:
            raise ScenarioError("--sea needs Capytaine, which solves for the hull's panels: pip install capytaine")
        numbers = np.geomspace(LEAST, MOST, FREQUENCIES) / upright.half_length_m
        fine, coarse = (_panels(points, faces, count) for count in (FINE_PANELS, COARSE_PANELS))
        some = np.array(COMPARED) / upright.half_length_m
        off = _difference(
            _solved(coarse, some, centre_z_m, density_kg_m3),
            _solved(fine, some, centre_z_m, density_kg_m3),
            upright.half_length_m,
        )
        content = _written(_solved(fine, numbers, centre_z_m, density_kg_m3))
        return np.array([len(coarse[1]), len(fine[1]), *off]), np.frombuffer(content, np.uint8)

    inputs = (points, faces, mass_kg, centre_z_m, density_kg_m3, COARSE_PANELS, FINE_PANELS, FREQUENCIES)
    own = Path(__file__).read_bytes()  # outside of the sources that the cache knows
    measured, content = cached_arrays(make, "sea", own, *inputs)
    write_atomically(path, content.tobytes())
    coarse, fine, *off = np.asarray(measured, np.float64).tolist()
    side = "above" if centre_z_m >= 0.0 else "below"
    return (
        f"its radiation table '{path}': {fine:.0f} panels; with {coarse:.0f}, added mass, damping and waves' force "
        f"differ by up to {100.0 * off[0]:.1f}, {100.0 * off[1]:.1f} and {100.0 * off[2]:.1f} % of the largest; "
        f"turns and moments are about the centre of mass, {abs(centre_z_m):.3g} m {side} the waterline"
    )


def _panels(points_m: Array, triangles: NDArray[np.integer], count: int) -> tuple[Array, NDArray[np.integer]]:
    """Return about `count` triangles under water, z = 0, of nearly equal size."""
    from uwsim.base.whole_trimesh import trimesh

    plain = trimesh.Trimesh(*simplified(points_m, triangles, GIVEN_TRIANGLES), process=False)
    wet = trimesh.intersections.slice_mesh_plane(plain, (0.0, 0.0, -1.0), (0.0, 0.0, 0.0))  # type: ignore[no-untyped-call]
    edge_m = np.sqrt(4.0 / np.sqrt(3.0) * wet.area / count)
    for _ in range(20):
        cut, faces = trimesh.remesh.subdivide_to_size(  # type: ignore[no-untyped-call]
            wet.vertices, wet.faces, edge_m, max_iter=20
        )
        if len(faces) <= 1.3 * count:
            break
        edge_m *= 1.1
    merged = trimesh.Trimesh(cut, faces, process=True)
    return np.asarray(merged.vertices, np.float64), np.asarray(merged.faces, np.int64)


def _solved(
    panels: tuple[Array, NDArray[np.integer]], numbers_rad_m: Array, centre_z_m: float, density_kg_m3: float
) -> Any:
    """Return Capytaine's dataset of a hull in deep water, at infinite frequency, too."""
    import capytaine as cpt  # type: ignore[import-not-found, unused-ignore]
    import xarray as xr

    cpt.set_logging("ERROR")
    points, faces = panels
    mesh = cpt.Mesh(vertices=points, faces=faces[:, [0, 1, 2, 2]]).immersed_part()
    centre = (0.0, 0.0, centre_z_m)
    body = cpt.FloatingBody(
        mesh, lid_mesh=mesh.generate_lid(), dofs=cpt.rigid_body_dofs(rotation_center=centre), center_of_mass=centre
    )
    gravity_m_s2 = _core.Water().gravity_m_s2
    coordinates = {
        "omega": [*np.sqrt(gravity_m_s2 * numbers_rad_m), np.inf],
        "wave_direction": np.radians(HEADINGS_DEG),
        "radiating_dof": list(body.dofs),
        "water_depth": [np.inf],
        "rho": [density_kg_m3],
        "g": [gravity_m_s2],
    }
    data = cpt.BEMSolver().fill_dataset(xr.Dataset(coords=coordinates), body, n_jobs=1, progress_bar=False)
    data["disp_mass"] = density_kg_m3 * mesh.volume
    data["rotation_center"] = ("xyz", np.array(centre))
    return data


def _difference(coarse: Any, fine: Any, half_length_m: float) -> list[float]:
    """Return the largest differences of added mass, damping and forces as shares of the largest values."""
    lengths = np.array([1.0, 1.0, 1.0, *[half_length_m] * 3])
    shares = []
    for names, units in (
        (["added_mass"], np.multiply.outer(lengths, lengths)),
        (["radiation_damping"], np.multiply.outer(lengths, lengths)),
        (["diffraction_force", "Froude_Krylov_force"], lengths),
    ):
        first, second = (
            sum(np.squeeze(np.asarray(data[name].isel(omega=slice(0, len(COMPARED))))) for name in names) / units
            for data in (coarse, fine)
        )
        shares.append(float(np.abs(first - second).max() / np.abs(second).max()))
    return shares


def _written(data: Any) -> bytes:
    """Return the dataset as classic NetCDF, without Capytaine's settings, which have no type in it."""
    from capytaine.io.xarray import separate_complex_values  # type: ignore[import-not-found, unused-ignore]

    plain = separate_complex_values(data[KEPT])
    for axis in ("influenced_dof", "radiating_dof"):
        plain[axis] = [str(name) for name in plain[axis].values]
    plain.attrs = {"made_by": "uwsim vehicle --draft --sea", "capytaine_version": data.attrs["capytaine_version"]}
    unneeded = ("freq", "period", "body_name", "wavenumber", "wavelength")
    plain = plain.drop_vars([name for name in plain.coords if name in unneeded])
    with tempfile.TemporaryDirectory() as folder:
        plain.to_netcdf(Path(folder) / "table.nc", engine="scipy", format="NETCDF3_64BIT")
        return (Path(folder) / "table.nc").read_bytes()
