"""Fields of ocean models and tides in a world's water."""

import csv
import io
import lzma
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

from uwsim import Simulator, _core
from uwsim.mapping.files.georeference import metres_per_degree
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.build.tides import DOODSON, harmonic
from uwsim.scenario.read.ocean_file import read_ocean
from uwsim.scenario.spec.sensor import SensorMount

MONTEREY = Path(__file__).parents[4] / "shared/reality/ocean/2003080103_mb_l3_las_1x1km.csv.xz"
LATITUDE_DEG, LONGITUDE_DEG = 36.8065, -121.824
NAMES = {
    "u": "eastward_sea_water_velocity", "v": "northward_sea_water_velocity", "t": "sea_water_temperature",
    "s": "sea_water_salinity",
}  # fmt: skip
UNITS = {"u": "m s-1", "v": "cm s-1", "t": "K", "s": "psu"}
AXES = {
    "time": ("hours since 2026-05-01", np.array([5.0, 6.0])), "depth": ("m", np.array([0.0, 10.0, 30.0])),
    "latitude": ("degrees_north", LATITUDE_DEG + np.array([-0.01, 0.0, 0.01])),
    "longitude": ("degrees_east", LONGITUDE_DEG + np.array([-0.02, 0.02])),
}  # fmt: skip
SHAPE = tuple(len(axis) for _, axis in AXES.values())
HOUR_S = 3600.0
SCENE = f"""
name: sea
mission_time_s: 8000
earth: {{latitude_deg: {LATITUDE_DEG}, longitude_deg: {LONGITUDE_DEG}}}
terrain: {{source: noise, size_m: [40, 40], spacing_m: 1, bed_depth_m: 60}}
station: {{position_m: [-6, 0, 0], dock_m: [0, 0, -20]}}
vehicles: [{{name: rov, model: rov, start: station}}]
water:
"""


def fields() -> dict[str, np.ndarray]:
    """Return fields that are linear along each axis, in SI units, deg C and psu."""
    t, z, y, x = np.meshgrid(*(axis - axis[0] for _, axis in AXES.values()), indexing="ij")
    return {
        "u": 0.1 + 0.2 * t - 0.002 * z + 5.0 * y, "v": -0.05 * t + 1.0 * x, "t": 15.0 - 0.2 * z + t + 50.0 * y,
        "s": 33.0 + 0.02 * z + 10.0 * x,
    }  # fmt: skip


def write(path: Path, kind: str) -> Path:
    """Write the fields as classic NetCDF, NetCDF in HDF5 or CSV."""
    values = fields()
    values["v"], values["t"] = 100.0 * values["v"], values["t"] + 273.15
    values["t"][:, 2, 0] = np.nan  # below the bed
    if kind == "csv":
        text = io.StringIO()
        unit = {"u": "meter_per_sec", "v": "cm_s", "t": "K", "s": "psu"}
        rows = csv.writer(text)
        rows.writerow(["elapsed_time_hours", "depth_meter", "latitude_degree", "longitude_degree",
                       *(f"{NAMES[key]}_{unit[key]}" for key in NAMES)])  # fmt: skip
        for at in np.ndindex(SHAPE):
            numbers = [axis[k] for (_, axis), k in zip(AXES.values(), at, strict=True)]
            rows.writerow(["" if np.isnan(n) else n for n in (*numbers, *(values[key][at] for key in NAMES))])
        path.write_text(text.getvalue())
        return path
    filled = {key: np.where(np.isnan(each), -999.0, each) for key, each in values.items()}
    if kind == "classic":
        with netcdf_file(path, "w") as data:
            for name, (unit, axis) in AXES.items():
                data.createDimension(name, len(axis))
                variable = data.createVariable(name, "d", (name,))
                variable[:], variable.units = axis, unit
            for key, name in NAMES.items():
                variable = data.createVariable(key, "d", tuple(AXES))
                variable[:], variable.units, variable.standard_name = filled[key], UNITS[key], name
                variable._FillValue = -999.0
        return path
    with h5py.File(path, "w") as data:
        for name, (unit, axis) in AXES.items():
            data[name] = axis
            data[name].attrs["units"] = unit
            data[name].make_scale(name)
        for key, name in NAMES.items():
            data[key] = filled[key]
            data[key].attrs.update(units=UNITS[key], standard_name=name, _FillValue=-999.0)
            for k, axis in enumerate(AXES):
                data[key].dims[k].attach_scale(data[axis])
    return path


def made(folder: Path, water: str, **sensors: dict) -> Simulator:
    (folder / "sea.yaml").write_text(SCENE + water)
    scenario = load(folder / "sea.yaml")
    mounts = {name: SensorMount.model_validate(mount) for name, mount in sensors.items()}
    entry = scenario.vehicles[0]
    entry = entry.model_copy(update={"model": entry.model.model_copy(update={"sensors": mounts})})
    return Simulator(scenario.model_copy(update={"vehicles": (entry,)}))


@pytest.mark.parametrize("kind", ["classic", "hdf5", "csv"])
def test_a_field_is_linear_in_space_and_time_and_instruments_read_it(tmp_path, kind):
    path = write(tmp_path / "ocean.nc", kind)
    sim = made(
        tmp_path, f"  current: {{kind: grid, file: {path}}}\n  profile: {{kind: field, file: {path}}}\n",
        ctd={"kind": "ctd"}, adcp={"kind": "adcp", "cell_count": 8},
    )  # fmt: skip
    north, east = metres_per_degree(LATITUDE_DEG)
    y_deg, x_deg, hours, depth_m = 0.004, -0.007, 0.25, 17.0
    point = (x_deg * east, y_deg * north, -depth_m)
    velocity = sim.world.water.velocity_m_s([point], hours * HOUR_S)[0]
    assert velocity[0] == pytest.approx(0.1 + 0.2 * hours - 0.002 * depth_m + 5.0 * (y_deg + 0.01), abs=1e-9)
    assert velocity[1] == pytest.approx(-0.05 * hours + (x_deg + 0.02), abs=1e-9)
    warm = 15.0 - 0.2 * depth_m + hours + 50.0 * (y_deg + 0.01)
    found = sim.world.water.temperature_at_deg_c([point], hours * HOUR_S)[0]
    assert found == pytest.approx(warm, abs=1e-6)
    sim.rov.place((0.0, 0.0, -8.0))
    read = sim.rov.sensors["ctd"].read()
    assert read.temperature_deg_c == pytest.approx(15.0 - 0.2 * 8.0 + 50.0 * 0.01, abs=1e-6)
    assert read.salinity_psu == pytest.approx(33.0 + 0.02 * 8.0 + 10.0 * 0.02, abs=1e-6)
    through = -sim.rov.sensors["adcp"].read().velocity_m_s
    assert through[:2] == pytest.approx([0.1 - 0.002 * 12.5 + 0.05, 0.02], abs=3e-3)


def test_the_speed_of_sound_follows_the_column_at_the_origin(tmp_path):
    path = write(tmp_path / "ocean.nc", "classic")
    water = made(tmp_path, f"  profile: {{kind: field, file: {path}}}\n").world.water
    speed = _core.sound_speed_m_s(15.0 - 0.2 * 5.0 + 0.5, 33.0 + 0.1 + 0.2, 5.0, "unesco")
    assert water.sound_speed_m_s(-5.0) == pytest.approx(speed, abs=0.05)


def test_the_monterey_bay_model_is_read_at_its_nodes(tmp_path):
    if not MONTEREY.is_file():
        pytest.skip("needs the file of the Monterey Bay model, which is not part of the repository")
    path = tmp_path / "monterey.csv"
    path.write_bytes(lzma.decompress(MONTEREY.read_bytes()))
    table = np.genfromtxt(path, delimiter=",", skip_header=1)
    whole = table[np.isfinite(table).all(axis=1)]
    sim = made(tmp_path, f"  current: {{kind: grid, file: {path}}}\n  profile: {{kind: field, file: {path}}}\n")
    north, east = metres_per_degree(LATITUDE_DEG)
    rows = whole[:: len(whole) // 500]
    at = np.column_stack([(rows[:, 2] - LONGITUDE_DEG) * east, (rows[:, 1] - LATITUDE_DEG) * north, -rows[:, 3]])
    np.testing.assert_allclose(sim.world.water.velocity_m_s(at)[:, :2], rows[:, 7:9], atol=1e-9)
    np.testing.assert_allclose(sim.world.water.temperature_at_deg_c(at), rows[:, 4], atol=1e-9)
    np.testing.assert_allclose(sim.world.water.salinity_at_points_psu(at), rows[:, 5], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        (("latitude_degree", "latitud"), "no column latitude_UNIT"),
        (("_cm_s", "_knots"), "unit 'knots': must be one of"),
        (("0.0,0.0,36.79", "x,0.0,36.79"), "elapsed_time_hours = 'x': must be a finite number"),
    ],
)
def test_a_bad_field_is_refused_with_its_file_and_the_rule(tmp_path, change, rule):
    path = write(tmp_path / "ocean.csv", "csv")
    text = path.read_text().replace("5.0,", "0.0,", 6).replace(*change, 1)
    path.write_text(text)
    with pytest.raises(ScenarioError, match=rule) as caught:
        read_ocean(path)
    assert "ocean.csv" in str(caught.value) and "\n" not in str(caught.value)


def test_a_cut_netcdf_and_a_world_without_a_place_are_refused(tmp_path):
    path = write(tmp_path / "ocean.nc", "classic")
    whole = path.read_bytes()
    with pytest.raises(ScenarioError, match="must have a place on Earth: give it the key earth"):
        (tmp_path / "sea.yaml").write_text(
            SCENE.replace("earth:", "description: sea #") + f"  current: {{kind: grid, file: {path}}}\n"
        )
        Simulator(load(tmp_path / "sea.yaml"))
    path.write_bytes(whole[:300])
    with pytest.raises(ScenarioError, match=r"ocean .*ocean\.nc"):
        read_ocean(path)


def test_a_floating_body_rides_on_the_tide_and_pressure_follows(tmp_path):
    tide = "  tide: {constituents: [{constituent: M2, amplitude_m: 2, phase_deg: 40}], begin: '2026-03-01T07:00:00Z'}\n"
    sim = made(tmp_path, tide, pressure={"kind": "pressure"})
    factor, speed, argument = harmonic("M2", "2026-03-01T07:00:00Z")
    for time_s in (0.0, 5000.0, 20000.0):
        level = 2.0 * factor * np.cos(speed * time_s + argument - np.radians(40.0))
        assert sim.world.water.surface_height_m([[3.0, 4.0]], time_s)[0] == pytest.approx(level, abs=1e-9)
    level = float(sim.world.water.surface_height_m([[0.0, 0.0]])[0])
    deeper_pa = sim.rov.sensors["pressure"].read() - sim.world.water.pressure_pa(-20.0)
    assert deeper_pa == pytest.approx(level * 1000 * 9.8, rel=5e-3)


def test_a_tidal_ellipse_has_its_axes_and_turns(tmp_path):
    text = (
        "  current: {kind: tide, constituent: K1, major_m_s: 0.5, minor_m_s: 0.2, inclination_deg: 30, phase_deg: 70}\n"
    )
    water = made(tmp_path, text).world.water
    factor, speed, argument = harmonic("K1", "2020-01-01T00:00:00Z")
    for time_s in np.linspace(0.0, 90000.0, 13).tolist():
        chi = speed * time_s + argument - np.radians(70.0)
        both = factor * np.exp(1j * np.radians(30.0)) * (0.5 * np.cos(chi) + 0.2j * np.sin(chi))
        assert water.velocity_m_s([[0, 0, -5]], time_s)[0][:2] == pytest.approx([both.real, both.imag], abs=1e-9)


@pytest.mark.parametrize("begin", ["1995-06-11T03:00:00Z", "2026-03-01T07:30:00Z"])
def test_arguments_are_those_of_another_library(begin):
    """utide's are for one time, with the satellites of each constituent; ours have Pugh's nodal corrections."""
    harmonics = pytest.importorskip("utide.harmonics", reason="needs utide, which is not a dependency")
    constituents = pytest.importorskip("utide._ut_constants").ut_constants.const
    from datetime import datetime

    time = datetime.fromisoformat(begin)
    days = time.toordinal() + (time.hour + time.minute / 60) / 24
    index = np.array([list(constituents.name).index(name.ljust(4)) if name.ljust(4) in list(constituents.name)
                      else list(constituents.name).index(name) for name in DOODSON])  # fmt: skip
    f, u, v = harmonics.FUV(np.array([days]), days, index, 45.0, [False, False, False, False])
    for k, name in enumerate(DOODSON):
        factor, _, argument = harmonic(name, begin)
        away = np.angle(np.exp(1j * (argument - 2 * np.pi * (u[0, k] + v[0, k]))))
        assert factor == pytest.approx(f[0, k], abs=0.06), name
        assert np.degrees(abs(away)) < 3.0, name
