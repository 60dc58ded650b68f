"""Tables as WAMIT and WEC-Sim's BEMIO write them are those of Capytaine from which these were made."""

import re
import shutil
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from uwsim.evidence.validate.peers.floating_hulls import barge, rigid_body, table_file
from uwsim.scenario.build.radiation import radiation
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.radiation_file import read_radiation
from uwsim.scenario.read.radiation_table import RadiationTable

OUT = """ Gravity:     9.81000                Length scale:        {length:.5f}
 Water depth:        infinite
 XBODY =    0.0000 YBODY =    0.0000 ZBODY =    0.0000 PHIBODY =   0.0
 Volumes (VOLX,VOLY,VOLZ):      {volume:.6f}    {volume:.6f}    {volume:.6f}
"""


def wamit_files(folder: Path, length_m: float = 1.0) -> Path:
    """Write the barge's table as WAMIT does: periods descending, headings [deg], the conjugates of the forces."""
    table = read_radiation(table_file("barge"))
    assert table.froude_krylov is not None and table.displaced_kg is not None
    units = np.array([1.0, 1.0, 1.0, length_m, length_m, length_m])
    pairs = 1000.0 * length_m**3 * np.multiply.outer(units, units)
    lines = [f" 0.0 {i + 1} {j + 1} {table.added_mass_infinite[i, j] / pairs[i, j]:.9e}" for i, j in np.ndindex(6, 6)]
    for omega, mass, damping in zip(table.omega_rad_s, table.added_mass, table.damping, strict=True):
        values = mass / pairs, damping / pairs / omega
        lines += [
            f" {2 * np.pi / omega:.9e} {i + 1} {j + 1} {values[0][i, j]:.9e} {values[1][i, j]:.9e}"
            for i, j in np.ndindex(6, 6)
        ]
    (folder / "barge.1").write_text("\n".join([" WAMIT Numeric Output -- Filename  barge.1", *lines]))
    for suffix, forces in ((".3", table.exciting), (".3fk", table.froude_krylov)):
        scaled = np.conj(forces / (1000.0 * 9.81 * length_m**2 * units))
        (folder / f"barge{suffix}").write_text(
            "\n".join(
                f" {2 * np.pi / table.omega_rad_s[w]:.9e} {np.degrees(table.heading_rad[h]):.6f} {i + 1} 0 0 "
                f"{scaled[w, h, i].real:.9e} {scaled[w, h, i].imag:.9e}"
                for w, h, i in np.ndindex(scaled.shape)
            )
        )
    assert table.drift is not None
    mean = table.drift / (9810.0 * length_m * np.array([1.0, 1.0, length_m]))
    (folder / "barge.8").write_text(
        "\n".join(
            f" {2 * np.pi / table.omega_rad_s[w]:.9e} {beta} {beta} {(1, 2, 6)[i]} 0 0 {mean[w, h, i]:.9e} 0"
            for w, h, i in np.ndindex(mean.shape)
            for beta in [f"{np.degrees(table.heading_rad[h]):.6f}"]
        )
    )
    (folder / "barge.out").write_text(OUT.format(length=length_m, volume=table.displaced_kg / 1000.0))
    return folder / "barge.1"


def wec_sim_file(folder: Path) -> Path:
    """Write the same as BEMIO does."""
    h5py = pytest.importorskip("h5py", reason="pip install 'uwsim[seakeeping]'")
    table = read_radiation(table_file("barge"))
    assert table.froude_krylov is not None and table.displaced_kg is not None
    body = "body1/hydro_coeffs"
    values = {
        "simulation_parameters/scaled": [[0.0]],
        "simulation_parameters/g": [[9.81]],
        "simulation_parameters/w": table.omega_rad_s[:, None],
        "simulation_parameters/wave_dir": np.degrees(table.heading_rad)[:, None],
        "body1/properties/cg": np.zeros((3, 1)),
        "body1/properties/disp_vol": [[table.displaced_kg / 1000.0]],
        f"{body}/added_mass/all": table.added_mass.transpose(1, 2, 0) / 1000.0,
        f"{body}/added_mass/inf_freq": table.added_mass_infinite / 1000.0,
        f"{body}/radiation_damping/all": table.damping.transpose(1, 2, 0) / table.omega_rad_s / 1000.0,
    }
    for name, force in (("excitation", table.exciting), ("excitation/froude-krylov", table.froude_krylov)):
        values[f"{body}/{name}/re"] = force.real.transpose(2, 1, 0) / 9810.0
        values[f"{body}/{name}/im"] = -force.imag.transpose(2, 1, 0) / 9810.0
    assert table.drift is not None
    values[f"{body}/mean_drift/momentum_conservation/val"] = np.zeros((6, *table.drift.shape[1::-1]))
    values[f"{body}/mean_drift/momentum_conservation/val"][[0, 1, 5]] = table.drift.transpose(2, 1, 0) / 9810.0
    with h5py.File(folder / "barge.h5", "w") as data:
        for name, value in values.items():
            data[name] = value
        data["simulation_parameters/water_depth"] = "infinite"
    return folder / "barge.h5"


def require_same(got: RadiationTable) -> None:
    wanted = read_radiation(table_file("barge"))
    for field in fields(wanted):
        value = getattr(wanted, field.name)
        if isinstance(value, np.ndarray):
            np.testing.assert_allclose(getattr(got, field.name), value, rtol=1e-6, atol=1e-6 * np.abs(value).max())
    assert got.displaced_kg == pytest.approx(wanted.displaced_kg, rel=1e-5)
    assert got.water_depth_m == wanted.water_depth_m and got.of_any_density


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with both programs' files, which are not changed."""
    folder = tmp_path_factory.mktemp("barge")
    wamit_files(folder)
    wec_sim_file(folder)
    return folder


@pytest.fixture
def barge_1(written: Path, tmp_path: Path) -> Path:
    """A copy of WAMIT's files, which may be changed."""
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    return tmp_path / "barge.1"


@pytest.mark.parametrize("length_m", [1.0, 2.0])
def test_wamits_files_are_the_table(length_m: float, tmp_path: Path) -> None:
    require_same(read_radiation(wamit_files(tmp_path, length_m)))


@pytest.mark.parametrize("suffix", [".7", ".9"])
def test_each_of_wamits_ways_to_the_drift_is_read(suffix: str, barge_1: Path) -> None:
    barge_1.with_suffix(".8").rename(barge_1.with_suffix(suffix))
    require_same(read_radiation(barge_1))


def test_without_files_of_drift_there_is_none(barge_1: Path) -> None:
    barge_1.with_suffix(".8").unlink()
    assert read_radiation(barge_1).drift is None


def test_wec_sims_file_is_the_table(written: Path) -> None:
    require_same(read_radiation(written / "barge.h5"))


@pytest.mark.parametrize("with_pressure", [True, False])
def test_a_hull_is_made_with_wamits_files_in_any_water_and_another_is_refused(
    with_pressure: bool, barge_1: Path
) -> None:
    path = barge_1
    if not with_pressure:
        barge_1.with_suffix(".3fk").unlink()
    mass_kg = 1100.0 * float(read_radiation(path).displaced_kg or 0.0) / 1000.0
    shape = barge(mass_kg / 1100.0)
    one = radiation(table_file("barge"), rigid_body(shape), shape.vertices_m, shape.triangles, 1000.0)
    other = radiation(path, rigid_body(shape, 1100.0), shape.vertices_m, shape.triangles, 1100.0)
    np.testing.assert_allclose(other.added_mass, 1.1 * one.added_mass, rtol=1e-3, atol=0.1)
    np.testing.assert_allclose(other.diffraction(2.5, 0.3), 1.1 * one.diffraction(2.5, 0.3), rtol=1e-3, atol=1.0)
    with pytest.raises(ScenarioError, match="another hull"):
        radiation(path, rigid_body(shape, 1100.0), shape.vertices_m * [1.25, 1.0, 1.0], shape.triangles, 1100.0)


@pytest.mark.parametrize(
    ("name", "old", "new", "text"),
    [
        ("barge.out", None, None, "'barge.out' beside it missing"),
        ("barge.3", None, None, "barge.3': missing"),
        ("barge.out", "PHIBODY =   0.0", "PHIBODY =   30.0", "PHIBODY = 30: must be 0 deg"),
        ("barge.out", "Water depth", "Depth", "depth missing: must be WAMIT's"),
        ("barge.1", " 0.0 ", " -1.0 ", "added mass at infinite frequency missing"),
        ("barge.1", " 1 1 ", " 7 1 ", "mode 7: must be 1 to 6"),
        ("barge.3", " 0 0 ", " zero 0 ", "line 2 must be numbers"),
        ("barge.8", " 0 0 ", " 0 ", "line 1 has 7 values, must have 8"),
        ("barge.8", " 6 0 0 ", " 5 0 0 ", "barge.8': must have a force for each period"),
        ("barge.8", "(?m) \\S+ 0$", " nan 0", "barge.8': must have a force for each period"),
        ("barge.8", "(?m) \\S+ 0$", " inf 0", "drift must be finite"),
        (
            "barge.8",
            " 15.000000 15.000000 ",
            " 15.000000 30.000000 ",
            "barge.8': its headings must be those of the file .3",
        ),
        ("barge.8", "^ ", " 9", "barge.8': period .* s is not in the file .1"),
        ("barge.3", " 0 0 ", " 0 ", "line 1 has 6 values, must have 7"),
    ],
)
def test_what_is_wrong_is_reported(name: str, old: str | None, new: str, text: str, barge_1: Path) -> None:
    broken = barge_1.with_name(name)
    if old is None:
        broken.unlink()
    else:
        broken.write_text(re.sub(old, new, broken.read_text()))
    with pytest.raises(ScenarioError, match=text) as caught:
        read_radiation(barge_1)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.zeros((6, 13)), "mean_drift must have 6 modes, 13 headings, 36 frequencies"),
        (np.full((6, 13, 36), np.nan), "drift must be finite"),
        ("none", "mean_drift/momentum_conservation/val must be numbers"),
    ],
)
def test_what_is_wrong_with_wec_sims_drift_is_reported(value: np.ndarray | str, text: str, barge_1: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="pip install 'uwsim[seakeeping]'")
    path = barge_1.with_suffix(".h5")
    with h5py.File(path, "a") as data:
        name = "body1/hydro_coeffs/mean_drift/momentum_conservation/val"
        del data[name]
        data[name] = value
    with pytest.raises(ScenarioError, match=rf"barge.h5': .*{text}") as caught:
        read_radiation(path)
    assert "\n" not in str(caught.value)
