"""Fields of ocean models and tides in a world's water."""

import csv
import io
import lzma
from datetime import datetime
from pathlib import Path
from typing import get_args

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

from uwsim import Simulator, _core
from uwsim.mapping.files.georeference import Georeference, metres_per_degree
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.build.measured_water import CONSTITUENTS, harmonic, ocean_current
from uwsim.scenario.read.ocean_file import read_ocean
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.water_parts import Constituent

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


@pytest.mark.parametrize("longitudes", [(179.98, 180.02), (-179.98, 179.98), (-180.02, -179.98)])
@pytest.mark.parametrize("origin_deg", [-179.995, 180.0])
def test_a_field_crosses_the_date_line(tmp_path, monkeypatch, longitudes, origin_deg):
    """However its longitudes count, it is linear from 179.98 E, where it is 0.1 m/s, to 179.98 W, where it is 0.3."""
    east_of_line = np.array(longitudes) % 360.0 > 180.0
    v = np.broadcast_to(np.where(east_of_line, 0.3, 0.1), SHAPE)
    monkeypatch.setitem(AXES, "longitude", ("degrees_east", np.array(longitudes)))
    monkeypatch.setitem(globals(), "fields", lambda: {key: v.copy() for key in "uvts"})
    path = write(tmp_path / "ocean.nc", "classic")
    scene = SCENE.replace(f"longitude_deg: {LONGITUDE_DEG}", f"longitude_deg: {origin_deg}")
    (tmp_path / "sea.yaml").write_text(scene + f"  current: {{kind: grid, file: {path}}}\n")
    water = Simulator(load(tmp_path / "sea.yaml")).world.water
    _, east = metres_per_degree(LATITUDE_DEG)
    for away_deg in (-0.01, 0.0, 0.005):
        share = ((origin_deg + away_deg) % 360.0 - 179.98) / 0.04
        assert water.velocity_m_s([[away_deg * east, 0, 0]])[0][1] == pytest.approx(0.1 + 0.2 * share, abs=1e-6)


def test_the_current_of_a_field_is_turned_to_the_worlds_axes(tmp_path, monkeypatch):
    """In UTM, a degree east of the zone's meridian, the y axis is 0.7 deg off north: PROJ moves what drifts."""
    crs = pytest.importorskip("rasterio.crs").CRS.from_epsg(32610)
    even = {"u": 0.3, "v": 0.1, "t": 10.0, "s": 33.0}
    monkeypatch.setitem(globals(), "fields", lambda: {key: np.full(SHAPE, value) for key, value in even.items()})
    world = Georeference(crs, (604_000.0, 4_074_000.0))
    current = ocean_current(write(tmp_path / "ocean.nc", "classic"), lambda: world)
    drifted = world.degrees(100.0 * current.velocity_m_s((0.0, 0.0, 0.0))[:2]) - world.degrees(np.zeros(2))
    north, east = drifted * metres_per_degree(LATITUDE_DEG)
    assert np.degrees(np.arctan2(east, north)) == pytest.approx(np.degrees(np.arctan2(0.3, 0.1)), abs=0.02)


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


def test_constituents_have_the_speeds_of_noaas_tables():
    """Degrees an hour, as NOAA's stations list them."""
    published = {
        "M2": 28.984104, "S2": 30.0, "N2": 28.43973, "K1": 15.041069, "M4": 57.96821, "O1": 13.943035, "M6": 86.95232,
        "MK3": 44.025173, "S4": 60.0, "MN4": 57.423832, "NU2": 28.512583, "S6": 90.0, "MU2": 27.968208,
        "2N2": 27.895355, "OO1": 16.139101, "LAM2": 29.455626, "J1": 15.5854435, "MM": 0.5443747, "SSA": 0.0821373,
        "MSF": 1.0158958, "MF": 1.0980331, "RHO": 13.471515, "Q1": 13.398661, "T2": 29.958933, "R2": 30.041067,
        "2Q1": 12.854286, "P1": 14.958931, "2SM2": 31.015896, "M3": 43.47616, "L2": 29.528479, "2MK3": 42.92714,
        "K2": 30.082138, "M8": 115.93642, "MS4": 58.984104,
    }  # fmt: skip
    assert set(published) == set(CONSTITUENTS) == set(get_args(Constituent))
    for name, degrees_an_hour in published.items():
        speed = np.degrees(harmonic(name, "2026-03-01T07:30:00Z").speed_rad_s) * HOUR_S
        assert speed == pytest.approx(degrees_an_hour, abs=1e-5), name


SMALL = {"OO1": (0.31, 19.0), "2N2": (0.18, 9.0), "RHO": (0.12, 7.0), "J1": (0.1, 6.0), "R2": (0.21, 7.0),
         "2Q1": (0.07, 5.0)}  # fmt: skip
"""Constituents of which ours have the first order of the nodes alone, as Pugh's table."""


@pytest.mark.parametrize("begin", ["1995-06-11T03:00:00Z", "2026-03-01T07:30:00Z"])
def test_arguments_are_those_of_another_library(begin):
    """utide's are for one time, with the satellites of each constituent, but none for MM and MF."""
    harmonics = pytest.importorskip("utide.harmonics", reason="needs utide, which is not a dependency")
    table = pytest.importorskip("utide._ut_constants").ut_constants.const
    theirs = {"RHO": "RHO1", "LAM2": "LDA2"}
    known = [name.strip() for name in table.name]
    names = [name for name in CONSTITUENTS if theirs.get(name, name) in known and name not in ("MM", "MF")]
    assert len(names) > 30
    time = datetime.fromisoformat(begin)
    days = time.toordinal() + (time.hour + time.minute / 60) / 24
    index = np.array([known.index(theirs.get(name, name)) for name in names])
    f, u, v = harmonics.FUV(np.array([days]), days, index, 45.0, [False, False, False, False])
    for k, name in enumerate(names):
        factor, _, argument = harmonic(name, begin)
        share, degrees = SMALL.get(name, (0.04, 3.0))
        away = np.angle(np.exp(1j * (argument - 2 * np.pi * (u[0, k] + v[0, k]))))
        assert factor == pytest.approx(f[0, k], rel=share), name
        assert np.degrees(abs(away)) < degrees, name
