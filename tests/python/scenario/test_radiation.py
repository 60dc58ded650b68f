"""A floating hull with a table of Capytaine makes and deflects waves; a table of another hull is refused."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.io import netcdf_file

from uwsim import Batch, Simulator
from uwsim.evidence.validate.peers import floating_hulls
from uwsim.evidence.validate.peers.floating_hulls import floating_hull, table_file
from uwsim.scenario.build.radiation import radiation_report
from uwsim.scenario.build.short_waves import ShortWavesWarning
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.radiation_file import read_radiation

Variables = dict[str, tuple[tuple[str, ...], np.ndarray]]
MASS_KG = 1000.0 * 2.0 * 0.8 * 0.3
SEA = {"kind": "jonswap", "significant_height_m": 0.1, "peak_period_s": 2.2}


def table(path: Path, change: Callable[[Variables], None] = lambda variables: None, name: str = "barge") -> Path:
    """Write a hull's table with a change."""
    with netcdf_file(table_file(name), mmap=False) as file:
        variables = {key: (each.dimensions, np.array(each.data)) for key, each in file.variables.items()}
    change(variables)
    with netcdf_file(path, "w") as file:
        for key, (axes, values) in variables.items():
            for axis, size in zip(axes, values.shape, strict=True):
                if axis not in file.dimensions:
                    file.createDimension(axis, size)
            file.createVariable(key, values.dtype.newbyteorder("="), axes)[...] = values
    return path


def barge_file(folder: Path, radiation: Path | None, **changes: Any) -> Path:
    """Write the barge of floating_hulls as a vehicle."""
    import trimesh

    trimesh.creation.box((2.0, 0.8, 0.5)).export(folder / "barge.obj")
    values = {
        "name": "barge", "mesh": "barge.obj", "mass_kg": MASS_KG, "centre_of_mass_m": [0.0, 0.0, 0.05],
        "inertia_kg_m2": [30.0, 161.0, 173.0], "linear_damping": [0] * 6, "quadratic_damping": [0] * 6,
        "added_mass": [30, 120, 250, 10, 50, 30], "max_force_n": [200, 200, 200], "max_torque_nm": [50, 50, 50],
    }  # fmt: skip
    if radiation is not None:
        values["radiation"] = str(radiation)
    path = folder / "barge.yaml"
    path.write_text(yaml.safe_dump({**values, **changes}))
    return path


def simulator(
    folder: Path, radiation: Path | None, z_m: float = -0.05, surface: Any = SEA, **changes: Any
) -> Simulator:
    """Return a simulator of the barge in a sea."""
    path = folder / "sea.yaml"
    world = {
        "name": "sea", "water": {"density_kg_m3": 1000, "surface": surface},
        "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 2, "bed_depth_m": 60},
        "vehicles": [{"name": "rov", "model": str(barge_file(folder, radiation, **changes)),
                      "start": {"position_m": [0, 0, z_m]}}],
    }  # fmt: skip
    path.write_text(yaml.safe_dump(world))
    return Simulator(path)


def drop_infinity(variables: Variables) -> None:
    kept = np.isfinite(variables["omega"][1])
    for key, (axes, values) in variables.items():
        if "omega" in axes:
            variables[key] = axes, np.compress(kept, values, axes.index("omega"))


def scaled(name: str, factor: float, where: Callable[[np.ndarray], np.ndarray] = lambda omega: omega > 0) -> Any:
    def change(variables: Variables) -> None:
        axes, values = variables[name]
        changed = np.array(values)
        if "omega" in axes:
            by_omega = np.moveaxis(changed, axes.index("omega"), 0)
            by_omega[where(variables["omega"][1])] *= factor
        else:
            changed *= factor
        variables[name] = axes, changed

    return change


def first_headings(variables: Variables) -> None:
    for key, (axes, values) in variables.items():
        if "wave_direction" in axes:
            variables[key] = axes, np.take(values, [0, 1, 2], axes.index("wave_direction"))


DRIFTS = ("drift_force_surge", "drift_force_sway", "drift_force_yaw")


def drift_of_pairs(variables: Variables) -> None:
    """Write the drift as Capytaine has it: complex, for each pair of headings."""
    for name in DRIFTS:
        values = variables[name][1]
        pairs = np.zeros((*values.shape, values.shape[1], 2))
        pairs[:, np.arange(values.shape[1]), np.arange(values.shape[1]), 0] = values
        variables[name] = (("omega", "wave_direction_k", "wave_direction_l", "complex"), pairs)


def drift_of_other_headings(variables: Variables) -> None:
    drift_of_pairs(variables)
    variables["wave_direction_k"] = (("wave_direction_k",), variables["wave_direction"][1] + 0.1)


def drift_of_fewer_headings(variables: Variables) -> None:
    variables[DRIFTS[0]] = ("omega", "fewer"), variables[DRIFTS[0]][1][:, :-1]


REFUSED = {
    "half a drift": (lambda v: v.pop("drift_force_yaw"), "has drift_force_surge, drift_force_sway alone: must have"),
    "no number": (scaled("drift_force_sway", np.nan), "drift must be finite"),
    "axes": (drift_of_fewer_headings, "drift_force_surge has 12 values along fewer: must be 1"),
    "other headings": (
        drift_of_other_headings,
        "wave_direction_k and wave_direction_l must have the values of wave_dir",
    ),
    "no infinite frequency": (drop_infinity, "added mass at infinite frequency missing"),
    "no damping": (lambda v: v.pop("radiation_damping"), "radiation_damping missing"),
    "displacement": (scaled("disp_mass", 1.2), "displaces 0.576 m3: this hull of 480 kg displaces 0.48 m3"),
    "pressure": (scaled("Froude_Krylov_force", 1.3), "Froude_Krylov_force in .* differs by .* another hull"),
    "energy": (scaled("radiation_damping", -1.0), "radiation_damping at .* adds energy"),
    "one infinite mass": (scaled("added_mass", 3.0, np.isinf), "the best passive fit is wrong by"),
    "headings": (first_headings, "wave_direction leaves a gap of 300 deg: must be at most 46 deg"),
    "dry water": (scaled("rho", 0.8), "rho = 800 kg/m3: must be within 5%"),
    "moving": (lambda v: v.update(forward_speed=((), np.array(1.5))), "forward_speed must be 0 m/s"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_table_that_does_not_fit_is_refused_with_what_is_wrong(case: str, tmp_path: Path) -> None:
    change, text = REFUSED[case]
    with pytest.raises(ScenarioError, match=rf"barge.yaml:\d+: radiation '.*table.nc': {text}"):
        simulator(tmp_path, table(tmp_path / "table.nc", change))


def test_other_files_and_other_hulls_are_refused(tmp_path: Path) -> None:
    other = tmp_path / "other.nc"
    other.write_text("no table")
    with pytest.raises(ScenarioError, match=r"must be a NetCDF file of Capytaine.*neither classic NetCDF nor HDF5"):
        simulator(tmp_path, other)
    other.write_bytes(table_file("barge").read_bytes()[:5000])
    with pytest.raises(ScenarioError, match=r"radiation '.*other.nc'"):
        simulator(tmp_path, other)
    with pytest.raises(ScenarioError, match=r"displaces 0.58.. m3: this hull of 480 kg displaces 0.48 m3"):
        simulator(tmp_path, table_file("cylinder"))
    with pytest.raises(ScenarioError, match="the hull does not float: 900 kg is more than the 800 kg of water"):
        simulator(tmp_path, table_file("barge"), mass_kg=900.0)
    with pytest.raises(ValueError, match="the table's frequencies leave out 100 % of the energy of the sea's waves"):
        simulator(tmp_path, table_file("barge"), surface={"kind": "airy", "amplitude_m": 0.5, "period_s": 9.0})


def test_a_table_in_hdf5_is_the_same(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="pip install 'uwsim[seakeeping]'")
    path = tmp_path / "table.nc"
    with netcdf_file(table_file("barge"), mmap=False) as file, h5py.File(path, "w") as copy:
        arrays = {key: (each.dimensions, np.array(each.data)) for key, each in file.variables.items()}
        for key, (axes, values) in arrays.items():
            if axes[:1] == (key,):  # a coordinate
                names = values.dtype.kind == "S"
                held = np.array([b"".join(row) for row in values], dtype=object) if names else values
                copy.create_dataset(key, data=held, dtype=h5py.string_dtype() if names else None)
                copy[key].make_scale(key)
        for key, (axes, values) in arrays.items():
            if key in copy or values.dtype.kind == "S":
                continue
            copy[key] = values
            for k, axis in enumerate(axes):
                copy[key].dims[k].attach_scale(copy[axis])
    one, other = read_radiation(table_file("barge")), read_radiation(path)
    for name in ("omega_rad_s", "added_mass", "damping", "exciting", "froude_krylov", "added_mass_infinite"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_capytaines_drift_of_pairs_of_headings_is_that_of_their_diagonal(tmp_path: Path) -> None:
    one, other = read_radiation(table_file("barge")), read_radiation(table(tmp_path / "pairs.nc", drift_of_pairs))
    np.testing.assert_array_equal(one.drift, other.drift)


def test_the_fit_follows_the_table() -> None:
    for name in ("hemisphere", "cylinder", "barge"):
        hull = floating_hull(name)
        low = hull.table.omega_rad_s < 8.0  # beyond, the table's own error shows
        omega, infinite = hull.table.omega_rad_s[low], hull.model.added_mass
        memory = np.array([hull.model.impedance(1j * each) for each in omega])
        added = infinite[2, 2] + memory[:, 2, 2].imag / omega
        assert np.abs(added / hull.table.added_mass[low, 2, 2] - 1.0).max() < 0.015
        damping = hull.table.damping[low, 2, 2]
        assert np.abs(memory[:, 2, 2].real - damping).max() < 0.015 * damping.max()
    assert np.abs(floating_hull("barge").model.impedance(0.0)).max() < 1e-6 * np.abs(memory).max(), "steady motion"


def test_its_share_falls_continuously_as_it_dives_capsizes_or_leaves_the_water() -> None:
    model = floating_hull("barge").model
    assert model.share(0.48, 1.0, -0.1) == model.share(0.8, 0.9, 0.0) == 1.0
    assert model.share(0.8, 1.0, 0.5) == model.share(0.48, 0.5, -0.1) == model.share(0.0, 1.0, -0.3) == 0.0
    for shares in (
        [model.share(0.8, 1.0, cover) for cover in np.linspace(0.0, 0.5, 200)],
        [model.share(0.48, up, -0.1) for up in np.linspace(1.0, 0.5, 200)],
        [model.share(wet, 1.0, -0.3) for wet in np.linspace(0.48, 0.0, 200)],
    ):
        assert np.all(np.diff(shares) <= 0.0) and np.abs(np.diff(shares)).max() < 0.02


def test_deep_under_water_it_moves_as_without_a_table(tmp_path: Path) -> None:
    still = {"kind": "still"}
    depth_m = -4.0
    one = simulator(tmp_path, table_file("barge"), depth_m, SEA)
    other = simulator(tmp_path, None, depth_m, SEA)
    for sim in (one, other):
        sim.rov.set_effort(surge=0.5, heave=-1.0)
        sim.advance(0.5)
    np.testing.assert_allclose(one.rov.pose.position_world_m, other.rov.pose.position_world_m, rtol=1e-12)
    assert np.linalg.norm(one.rov.forces["radiation"].force_body_n) == 0.0
    assert "radiation" not in other.rov.forces
    assert simulator(tmp_path, table_file("barge"), surface=still).rov is not None


def test_the_forces_of_a_step_are_its_change_of_momentum(tmp_path: Path) -> None:
    sim = simulator(tmp_path, table_file("barge"))
    sim.rov.set_effort(surge=0.3, yaw=0.2)
    sim.advance(3.0)
    before = np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s])
    sim.step()
    after = np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s])
    forces = sim.rov.forces
    total = np.concatenate([forces["total"].force_body_n, forces["total"].torque_body_nm])
    centre, mass = np.array([0.0, 0.0, 0.05]), MASS_KG
    change = (after - before) / sim.scenario.step_s
    expected = mass * (change[:3] + np.cross(change[3:], centre))
    np.testing.assert_allclose(total[:3], expected, rtol=1e-9, atol=1e-6)
    assert np.linalg.norm(forces["diffraction"].force_body_n) > 1.0
    assert np.linalg.norm(forces["radiation"].force_body_n) > 0.1


def test_a_restored_state_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    one, other = (simulator(tmp_path, table_file("barge")) for _ in range(2))
    one.advance(3.0)
    state = one.save_state()
    one.advance(2.0)
    other.restore_state(state)
    other.advance(2.0)
    assert one.save_state() == other.save_state()


def test_members_of_a_batch_move_as_alone(tmp_path: Path) -> None:
    simulator(tmp_path, table_file("barge"))
    batch = Batch(tmp_path / "sea.yaml", n=2, seeds=range(2))
    batch.step(200)
    for seed in range(2):
        alone = Simulator(tmp_path / "sea.yaml", seed=seed)
        alone.step(200)
        assert alone.save_state() == batch.save_state(seed)


def test_another_mass_is_refused_but_not_a_leak(tmp_path: Path) -> None:
    sim = simulator(tmp_path, table_file("barge"))
    sim.advance(1.0)
    with pytest.raises(ScenarioError, match=r"this hull of 600 kg displaces 0\.6 m3"):
        sim.parameters["rov.mass_kg"] = 600.0
    sim.parameters["rov.ballast_kg"] = 60.0
    before_m = sim.rov.pose.position_world_m[2]
    sim.advance(2.0)
    assert sim.rov.pose.position_world_m[2] < before_m - 0.01


def test_a_hull_turned_with_the_sea_moves_alike(tmp_path: Path) -> None:
    moved = []
    for turn_deg in (0.0, 117.0):
        surface = {"kind": "airy", "amplitude_m": 0.02, "period_s": 1.8, "heading_deg": 40.0 + turn_deg}
        sim = simulator(tmp_path, table_file("barge"), surface=surface)
        pose = {"position_m": [0.0, 0.0, -0.05], "yaw_deg": turn_deg}
        sim = Simulator(changed_start(tmp_path, pose))
        sim.advance(4.0)
        moved.append([sim.rov.pose.position_world_m[2], *sim.rov.velocity.linear_body_m_s])
    np.testing.assert_allclose(moved[0], moved[1], rtol=1e-6, atol=1e-9)


def changed_start(folder: Path, pose: dict[str, Any]) -> Path:
    """Write the scenario that `simulator` has written with another start."""
    path = folder / "sea.yaml"
    world = yaml.safe_load(path.read_text())
    world["vehicles"][0]["start"] = pose
    path.write_text(yaml.safe_dump(world))
    return path


def test_short_waves_are_warned_of_only_where_the_table_is_not_valid(tmp_path: Path) -> None:
    def warned(radiation: Path | None, surface: Any) -> list[str]:
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always")
            simulator(tmp_path, radiation, surface=surface)
        return [str(each.message) for each in issued if issubclass(each.category, ShortWavesWarning)]

    assert "shorter than 5 of its lengths" in warned(None, SEA)[0]
    assert warned(table_file("barge"), SEA) == []
    high = {**SEA, "significant_height_m": 0.4}
    assert "its radiation table is linear, but the waves are 0.4 m high" in warned(table_file("barge"), high)[0]


def test_a_report_states_the_fit() -> None:
    shape = floating_hulls.barge(0.48)
    report = radiation_report(
        table_file("barge"), floating_hulls.rigid_body(shape), shape.vertices_m, shape.triangles, 1000.0
    )
    assert report.sections <= 9 and report.error < 0.04 and np.isinf(report.water_depth_m)
    assert (report.least_rad_s, report.most_rad_s) == pytest.approx((0.8, 11.0))
