"""Casts as instruments write them become the levels that their lines state, and the water of a scenario."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwsim
from uwsim import _core
from uwsim.scenario import ScenarioError
from uwsim.scenario.build.water import build_water
from uwsim.scenario.read.cast_file import Cast, read_cast
from uwsim.scenario.read.cast_levels import depth_at_m
from uwsim.scenario.read.errors import CastWarning
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.water import Water

SEA_BIRD = """* Sea-Bird SBE 19plus Data File:
# name 0 = prdM: Pressure, Strain Gauge [db]
# name 1 = t090C: Temperature [ITS-90, deg C]
# name 2 = t190C: Temperature, 2 [ITS-90, deg C]
# name 3 = sal00: Salinity, Practical [PSU]
# name 4 = flag: flag
# bad_flag = -9.990e-29
# file_type = ascii
*END*
     -0.010    15.1000    15.1000     0.0100 0.0000e+00
      1.000    15.0000    15.2000    35.0000 0.0000e+00
      2.000-9.990e-29    15.2000    35.1000 0.0000e+00
      3.000    14.5000    15.2000    35.1000-9.990e-29
      4.000    14.0000    15.2000    35.2000 0.0000e+00
      3.500    14.1000    15.2000    35.2000 0.0000e+00
"""
FILES: dict[str, tuple[str, dict[str, list[float]]]] = {
    "CARIS": (
        "[SVP_VERSION_2]\nC:\\casts\\one.svp\nSection 2024-126 14:33:12 43:51:34 -70:45:16\n0.50 1500.1\n9.50 1490.2\n"
        "Section 2024-127 14:33:12 43:51:34 -70:45:16\n0.50 1400.0\n",
        {"depth_m": [0.5, 9.5], "sound_speed_m_s": [1500.1, 1490.2]},
    ),
    "Kongsberg": (
        "( SoundVelocity  1.0 0 201203212242 22.5 -156.5 -1 0 0 OMS01 P 0002 )\n0.00 1531.40\n12000.00 1675.82\n",
        {"depth_m": [0.0, 12000.0], "sound_speed_m_s": [1531.4, 1675.82]},
    ),
    "AML": (
        "[cast header]\nsn=25101\n[data]\nDate (yyyy-mm-dd),Time,SV (m/s),Depth (m),Battery (V),\n"
        "2024-08-16,17:47:45.37,1545.481,0.32,007.30,\n2024-08-16,17:47:45.87,1545.486,1.24,007.30,\n",
        {"depth_m": [0.32, 1.24], "sound_speed_m_s": [1545.481, 1545.486]},
    ),
    "AML 3": (
        "[Header]\nModel=AML-3\n[MeasurementMetadata]\nColumns=Date,Time,SV,TempCT,Depth\nUnits=yyyy-mm-dd,hh:mm:ss,m/s,C,m\n"
        "\n[MeasurementData]\n2024-04-07,20:39:17.58,1460.4,5.7,0.3\n2024-04-07,20:39:18.08,1460.5,5.6,0.9\n",
        {"depth_m": [0.3, 0.9], "sound_speed_m_s": [1460.4, 1460.5], "temperature_deg_c": [5.7, 5.6]},
    ),
    "Valeport": (
        "[Columns]\nCount=3\n[Data]\nDate/Time\tDepth\tSound Velocity\tTemperature\n\tm\tm/s\tDegC\n"
        "07/27/2024 15:56:37.000\t2.0\t1537.4\t26.3\n07/27/2024 15:56:42.000\t2.1\t1537.5\t26.2\n",
        {"depth_m": [2.0, 2.1], "sound_speed_m_s": [1537.4, 1537.5], "temperature_deg_c": [26.3, 26.2]},
    ),
    "Valeport's text": (
        "Now: 05/06/2013 08:10:41\nMiniSVP: S/N 31597\nPressure units: m\n00.111\t20.941\t0000.000\n"
        "-0.004\t20.9\t1522.6\n00.122\t20.7\t1522.5\n03.122\t19.7\t1520.5\n",
        {"depth_m": [0.122, 3.122], "sound_speed_m_s": [1522.5, 1520.5], "temperature_deg_c": [20.7, 19.7]},
    ),
    "header rows and pairs": (
        "USGS\nLine 2 of the header, with 3 numbers\n0.0, 1504.92\n1.2, 1504.80\n",
        {"depth_m": [0.0, 1.2], "sound_speed_m_s": [1504.92, 1504.8]},
    ),
    "semicolons and decimal commas": (
        "Tiefe [m];Depth [m];Temp [°C];Salinity [PSU];O2\n1;0,5;12,25;30,1;8\n2;1,5;12,00;30,2;9\n",
        {"depth_m": [0.5, 1.5], "temperature_deg_c": [12.25, 12.0], "salinity_psu": [30.1, 30.2]},
    ),
    "spaces and feet": (
        "DEPTH (FT) VELOCITY (FT/S) TEMP (F)\n10.0 4900.0 50.0\n20.0 4890.0 41.0\n",
        {"depth_m": [3.048, 6.096], "sound_speed_m_s": [1493.52, 1490.472], "temperature_deg_c": [10.0, 5.0]},
    ),
    "up and down": (
        "depth_m,sound_speed_m_s\n3,1501\n1,1502\n2,1503\n1.5,1504\n4,1505\n2,1506\n0,1507\n",
        {"depth_m": [1.0, 2.0, 4.0], "sound_speed_m_s": [1502.0, 1503.0, 1505.0]},
    ),
    "upcast": (
        "depth_m,sound_speed_m_s\n5,1500\n4,1501\n3,1502\n2,1503\n1,1504\n",
        {"depth_m": [1, 2, 3, 4, 5], "sound_speed_m_s": [1504, 1503, 1502, 1501, 1500]},
    ),
    "ELAC": (
        "# depth veloc. temp. salin.\n# [m] [m/s] [?C] [o/oo]\n1.0 1500.0 0.00 0.00\n2.0 1501.0 0.00 0.00\n",
        {"depth_m": [1.0, 2.0], "sound_speed_m_s": [1500.0, 1501.0]},
    ),
    "Sippican": (
        "// This is a MK21 EXPORT DATA FILE  (EDF)\nTerminal Depth   :  2 m\n"
        "Depth (m) - Temperature (°C) - Sound Velocity (m/s)\n0.7\t20.5\t1523\n1.4\t20.4\t1522\n2.0\t35.50\t1561\n",
        {"depth_m": [0.7, 1.4], "sound_speed_m_s": [1523, 1522], "temperature_deg_c": [20.5, 20.4]},
    ),
    "Sippican's raw": (
        "// MK21 EXPORT DATA FILE  (EDF)\nField1 : Time (sec)\nField2 : Depth (m)\nField3 : Temperature (°C)\n// Data\n"
        "0.0\t0.6\t-99\n0.1\t1.3\t9.5\n0.2\t2.0\t9.4\n",
        {"depth_m": [1.3, 2.0], "temperature_deg_c": [9.5, 9.4]},
    ),
    "Sea & Sun": (
        "; Datasets  Depth   Temp  SOUND\n;   [  m] [ degC] [  m/s]\n;\n 1  0.5  18.9  1491.7\n 2  0.8  18.8  1491.5\n",
        {"depth_m": [0.5, 0.8], "temperature_deg_c": [18.9, 18.8], "sound_speed_m_s": [1491.7, 1491.5]},
    ),
    "WHP-Exchange, whose flags count": (
        "CTD,20130709ODF\nDEPTH = 166\nDEPTH,CTDTMP,CTDTMP_FLAG_W,CTDPRS\nM,ITS-90,,DBAR\n"
        "2,19.18,2,2\n4,-999,9,4\n6,29.2,4,6\n8,19.20,2,8\nEND_DATA\n",
        {"depth_m": [2.0, 8.0], "temperature_deg_c": [19.18, 19.2]},
    ),
}  # fmt: skip


def read(text: str, folder: Path) -> Cast:
    path = folder / "a cast.dat"  # its content alone states what it is
    path.write_text(text)
    return read_cast(path, "cast")


@pytest.mark.parametrize("kind", FILES)
def test_a_cast_has_the_levels_that_its_lines_state(kind: str, tmp_path: Path) -> None:
    text, expected = FILES[kind]
    columns = read(text, tmp_path).columns
    assert columns.keys() == expected.keys()
    for key, values in expected.items():
        np.testing.assert_allclose(columns[key], values, rtol=1e-12, atol=1e-12, err_msg=key)


def test_a_sea_bird_file_is_read_by_its_names_without_bad_samples(tmp_path: Path) -> None:
    cast = read(SEA_BIRD, tmp_path)
    np.testing.assert_allclose(cast.columns["depth_m"], depth_at_m(np.array([1.0, 4.0])))
    np.testing.assert_array_equal(cast.columns["temperature_deg_c"], [15.0, 14.0])
    np.testing.assert_array_equal(cast.columns["salinity_psu"], [35.0, 35.2])
    assert list(cast.lines) == [11, 14]
    assert [note for note in cast.notes if "flagged as bad" in note or "t190C, flag" in note] == [
        "1 samples that are flagged as bad are left out", "columns that are not used: t190C, flag",
    ]  # fmt: skip


def test_the_depth_at_a_pressure_is_unescos() -> None:
    assert depth_at_m(np.array([10_000.0]), 30.0)[0] == pytest.approx(9712.653, abs=5e-4)


def write_argo(path: Path, temperature_flags: str = "141") -> None:
    """Write a profile of an Argo float: three levels, by default the second with a bad temperature."""
    from scipy.io import netcdf_file

    with netcdf_file(path, "w") as file:
        file.createDimension("N_PROF", 1)
        file.createDimension("N_LEVELS", 3)
        file.createVariable("DATA_MODE", "c", ("N_PROF",))[:] = b"D"
        file.createVariable("LATITUDE", "d", ("N_PROF",))[:] = 60.0
        for name, values in (("PRES", [5, 10, 20]), ("TEMP", [9, 8, 7]), ("PSAL", [34, 35, 36])):
            file.createVariable(name, "f", ("N_PROF", "N_LEVELS"))[:] = 0.0
            adjusted = file.createVariable(f"{name}_ADJUSTED", "f", ("N_PROF", "N_LEVELS"))
            adjusted[:], adjusted._FillValue = [values], np.float32(99999.0)
            flags = file.createVariable(f"{name}_ADJUSTED_QC", "c", ("N_PROF", "N_LEVELS"))
            flags[:] = np.array([list(temperature_flags if name == "TEMP" else "111")], "S1")


def test_an_argo_profile_has_its_adjusted_good_values(tmp_path: Path) -> None:
    write_argo(path := tmp_path / "float")
    columns = read_cast(path).columns
    np.testing.assert_allclose(columns["depth_m"], depth_at_m(np.array([5.0, 20.0]), 60.0))
    np.testing.assert_array_equal([columns["temperature_deg_c"], columns["salinity_psu"]], [[9, 7], [34, 36]])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("depth_m,sound_speed_m_s\n0,1500\n1,abc\n", "cast:3: sound_speed_m_s = 'abc': must be a number"),
        ("depth_m,sound_speed_m_s\n0,1500\n1\n", "cast:3: 1 values: must be 2, one for each column"),
        ("depth [cubit],temperature\n0,15\n", "column 'depth [cubit]': unit 'cubit': must be one of m, meter"),
        ("depth;salinity\n0;35\n", "not a cast: no line names its columns"),
        ("1,2,1500\n2,3,1500\n", "not a cast: no line names its columns"),
        (SEA_BIRD.replace("= ascii", "= binary"), "cast:8: a .cnv whose values are binary"),
        ("", "not a cast"),
    ],
)
def test_a_mistake_is_reported_with_its_line(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^cast") as caught:
        read(text, tmp_path)
    assert words in str(caught.value)


def scenario(folder: Path, profile: str, sensors: str = "{temperature: null}") -> Path:
    (folder / "cast.svp").write_text(FILES["CARIS"][0])
    (folder / "own.yaml").write_text(f"name: own\nbuilds_on: rov\nsensors: {sensors}\n")
    path = folder / "sea.yaml"
    path.write_text(
        f"name: sea\nwater:\n  profile: {profile}\n"
        "terrain: {source: noise, size_m: [40, 40], bed_depth_m: 18}\n"
        "vehicles:\n- {name: rov, model: own.yaml, start: {position_m: [0, 0, -3]}}\n"
    )
    return path


def test_with_sound_speed_alone_the_temperature_is_unknown_and_the_assumption_is_named(tmp_path: Path) -> None:
    with pytest.warns(CastWarning, match="the first of its 2 casts.*without temperature_deg_c: density.*10 deg C"):
        sim = uwsim.Simulator(scenario(tmp_path, "{kind: table, file: cast.svp}"))
    water = sim.world.water
    assert water.sound_speed_m_s(-5.0) == pytest.approx(1495.15)
    assert water.density_at_kg_m3(-5.0) == pytest.approx(_core.sea_water_density_kg_m3(10.0, 0.0))
    sim.step(1)
    assert np.isnan(sim.rov.telemetry().temperature_deg_c) and sim.rov.telemetry().pressure_pa > 1e5
    with warnings.catch_warnings(), pytest.raises(ScenarioError) as caught:
        warnings.simplefilter("ignore", CastWarning)
        uwsim.Simulator(scenario(tmp_path, "{kind: table, file: cast.svp}", "{}"))
    assert "sensor 'temperature': needs the temperature of the water, which water.profile does not have" in str(
        caught.value
    )


def test_what_a_cast_lacks_may_be_stated(tmp_path: Path) -> None:
    stated = "{kind: table, file: cast.svp, temperature_deg_c: 12, salinity_psu: 35}"
    with pytest.warns(CastWarning) as given:
        sim = uwsim.Simulator(scenario(tmp_path, stated, "{}"))
    assert not any("without" in str(warning.message) for warning in given)
    assert sim.world.water.density_at_kg_m3(-5.0) == pytest.approx(_core.sea_water_density_kg_m3(12.0, 35.0))
    assert sim.rov.telemetry().temperature_deg_c == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        ({"levels": [{"depth_m": 0}]}, "levels[0].temperature_deg_c: must be given, or sound_speed_m_s"),
        (
            {"levels": [{"depth_m": 0, "sound_speed_m_s": 1500},
                        {"depth_m": 1, "sound_speed_m_s": 1500, "temperature_deg_c": 9}]},
            "levels[1].temperature_deg_c: must be given at all levels or at none",
        ),
        (
            {"levels": [{"depth_m": 0, "temperature_deg_c": 9}], "temperature_deg_c": 9},
            "profile.temperature_deg_c = 9: must not be given: the levels have it",
        ),
        ({"file": "warm.csv", "temperature_deg_c": 9}, "must not be given: the levels have it"),
        ({"file": "hot.csv"}, "hot.csv':3: temperature_deg_c = 95 deg C: must be in [-2, 40] deg C"),
    ],
)  # fmt: skip
def test_a_profile_that_contradicts_itself_is_refused(profile: dict[str, Any], words: str, tmp_path: Path) -> None:
    (tmp_path / "warm.csv").write_text("depth_m,temperature_deg_c\n0,15\n")
    (tmp_path / "hot.csv").write_text("depth_m,temperature_deg_c\n0,15\n1,95\n2,96\n")
    with pytest.raises(ScenarioError) as caught:
        water = validated(Water, {"profile": {"kind": "table", **profile}}, folder=tmp_path)
        build_water(water, bottom_depth_m=20.0, seed=0)
    assert words in str(caught.value) and len(caught.value.mistakes) == 1
