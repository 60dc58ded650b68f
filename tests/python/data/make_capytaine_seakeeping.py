"""Makes python/uwsim/evidence/validate/peers/seakeeping_*.nc with Capytaine 3.0.0 and its lids.

Run: pip install capytaine, then python make_capytaine_seakeeping.py FOLDER. It also writes the barge's motion at speed
and its drift between the table's frequencies, which are in seakeeping.py. Each file is Capytaine's own dataset, in
NetCDF's classic format and single precision. Frames: z = 0 is the waterline, x forward.
"""

import sys
from pathlib import Path
from typing import Any

import capytaine as cpt
import numpy as np
import xarray as xr
from capytaine.io.xarray import separate_complex_values
from capytaine.post_pro import far_field_mean_drift_force
from numpy.typing import NDArray

OMEGA_RAD_S = [*np.geomspace(0.8, 11.0, 36), np.inf]
HEADINGS_RAD = np.radians(np.arange(0.0, 181.0, 15.0))
KEPT = ["added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force", "inertia_matrix"]
KEPT += ["hydrostatic_stiffness", "disp_mass", "center_of_buoyancy"]


def hemisphere() -> cpt.Mesh:
    """Return a ball of radius 0.5 m that floats to its equator."""
    return cpt.mesh_sphere(radius=0.5, center=(0, 0, 0), resolution=(64, 80))


def cylinder() -> cpt.Mesh:
    """Return a vertical cylinder of radius 0.5 m and draught 0.75 m."""
    return cpt.mesh_vertical_cylinder(radius=0.5, length=1.5, center=(0, 0, 0), resolution=(8, 32, 20))


def barge() -> cpt.Mesh:
    """Return a box of 2 x 0.8 m and draught 0.3 m."""
    return cpt.mesh_parallelepiped(size=(2.0, 0.8, 0.6), center=(0, 0, 0), resolution=(24, 12, 10))


def dataset(mesh: cpt.Mesh, centre_of_mass_z_m: float, omega_rad_s: list[float] = OMEGA_RAD_S) -> xr.Dataset:
    """Return the hydrodynamics of the part under water, about its centre of mass."""
    wet = mesh.immersed_part()
    centre = (0.0, 0.0, centre_of_mass_z_m)
    body = cpt.FloatingBody(
        mesh=wet,
        lid_mesh=wet.generate_lid(),
        dofs=cpt.rigid_body_dofs(rotation_center=centre),
        center_of_mass=centre,
    )
    body.inertia_matrix = body.compute_rigid_body_inertia()
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness()
    problems = xr.Dataset(
        coords={
            "omega": omega_rad_s,
            "wave_direction": HEADINGS_RAD,
            "radiating_dof": list(body.dofs),
            "water_depth": [np.inf],
            "rho": [1000.0],
        }
    )
    return cpt.BEMSolver().fill_dataset(problems, body, n_jobs=1)


def mean_drift(name: str, omega_rad_s: list[float], headings_rad: NDArray[np.float64]) -> dict[str, Any]:
    """Return the mean drift of a free hull of floating_hulls.py, (frequencies, headings), by Capytaine's names."""
    mesh, centre_of_mass_z_m = next((mesh, z_m) for each, mesh, z_m in CASES if each == name)
    wet = mesh.immersed_part()
    centre = (0.0, 0.0, centre_of_mass_z_m)
    dofs = cpt.rigid_body_dofs(rotation_center=centre)
    body = cpt.FloatingBody(mesh=wet, lid_mesh=wet.generate_lid(), dofs=dofs, center_of_mass=centre)
    body.hydrostatic_stiffness = body.compute_hydrostatic_stiffness()
    coords = {
        "omega": omega_rad_s,
        "wave_direction": headings_rad,
        "radiating_dof": list(body.dofs),
        "theta": np.radians(np.arange(-12.5, 372.6, 2.5)),
        "water_depth": [np.inf],
        "rho": [1000.0],
    }
    far = cpt.BEMSolver().fill_dataset(xr.Dataset(coords=coords), body, n_jobs=1)
    mass = body.disp_mass() * np.diag([1.0, 1.0, 1.0, *np.square(RADII_M[name])])
    far["inertia_matrix"] = (("influenced_dof", "radiating_dof"), mass)
    found = far_field_mean_drift_force(cpt.post_pro.rao(far), far)
    return {str(each): np.real(np.diagonal(values.values, axis1=1, axis2=2)) for each, values in found.items()}


def with_drift(name: str, data: xr.Dataset) -> xr.Dataset:
    """Return a hull's dataset with its mean drift; none at infinite frequency."""
    for each, values in mean_drift(name, OMEGA_RAD_S[:-1], HEADINGS_RAD).items():
        padded = np.concatenate([values, np.full_like(values[:1], np.nan)])
        data[each] = (("omega", "wave_direction"), padded.astype(np.float32))
    return data


def written(data: xr.Dataset, path: Path) -> None:
    """Write it as other programs read it: without Capytaine's settings, which have no type in the classic format."""
    plain = separate_complex_values(data[[*KEPT, *(name for name in data if str(name).startswith("drift_force"))]])
    for axis in ("influenced_dof", "radiating_dof"):
        plain[axis] = [str(name) for name in plain[axis].values]
    plain.attrs = {"capytaine_version": data.attrs["capytaine_version"]}
    plain = plain.drop_vars(
        [k for k in plain.coords if k in ("freq", "period", "body_name", "wavenumber", "wavelength")]
    )
    encoding = {name: {"dtype": "float32"} for name in plain.data_vars if plain[name].dtype == np.float64}
    plain.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT", encoding=encoding)


def responses_at_speed(speed_m_s: float, omega_rad_s: float) -> tuple[float, float]:
    """Return heave over amplitude and pitch over slope of the barge of floating_hulls.py, moving into the waves."""
    wet = barge().immersed_part()
    centre = (0.0, 0.0, 0.0)
    body = cpt.FloatingBody(
        mesh=wet,
        lid_mesh=wet.generate_lid(),
        dofs=cpt.rigid_body_dofs(rotation_center=centre),
        center_of_mass=centre,
        mass=480.0,
    )
    mass = 480.0 * np.diag([1.0, 1.0, 1.0, 0.25**2, 0.58**2, 0.6**2])
    stiffness = body.compute_hydrostatic_stiffness().values
    moving = {"body": body, "omega": omega_rad_s, "wave_direction": np.pi, "forward_speed": speed_m_s}
    fixed = cpt.DiffractionProblem(**moving)
    radiating = [cpt.RadiationProblem(**moving, radiating_dof=name) for name in body.dofs]
    diffraction, *moved = cpt.BEMSolver().solve_all([fixed, *radiating])
    pressure = cpt.bem.airy_waves.froude_krylov_force(fixed)
    force = np.array([diffraction.forces[name] + pressure[name] for name in body.dofs])
    added = np.array([[each.added_masses[name] for each in moved] for name in body.dofs])
    damping = np.array([[each.radiation_dampings[name] for each in moved] for name in body.dofs])
    omega = fixed.encounter_omega
    motion = np.abs(np.linalg.solve(-(omega**2) * (mass + added) - 1j * omega * damping + stiffness, force))
    return motion[2], motion[4] * 9.81 / omega_rad_s**2


RADII_M = {"hemisphere": (0.25, 0.25, 0.25), "barge": (0.25, 0.58, 0.6)}
"""Radii of gyration of the hulls whose drift is computed [m]."""
CASES = (("hemisphere", hemisphere(), -0.1), ("cylinder", cylinder(), -0.5), ("barge", barge(), 0.0))


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for name, mesh, centre_z_m in CASES:
        made = dataset(mesh, centre_z_m)
        if name in RADII_M:
            made = with_drift(name, made)
        written(made, folder / f"seakeeping_{name}.nc")
    rows = [(omega_rad_s, *responses_at_speed(0.268, omega_rad_s)) for omega_rad_s in (2.5, 3.5, 4.2)]
    np.savetxt(folder / "seakeeping_at_speed.txt", rows, "%.3f", header="rad/s, heave over amplitude, pitch over slope")
    drifts = [
        (omega_rad_s, mean_drift("barge", [omega_rad_s], HEADINGS_RAD[:2])["drift_force_surge"][0, 0])
        for omega_rad_s in (2.5, 3.5, 3.8, 4.2, 4.8, 5.5, 6.5, 8.5)
    ]
    np.savetxt(folder / "seakeeping_drift.txt", drifts, "%.4g", header="rad/s, N/m2, of the barge in head waves")
