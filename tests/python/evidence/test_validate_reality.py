"""Data that others measured: thrust, noise of instruments, a surveyed sea floor. The files are not packaged."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from uwsim.cli.program import app
from uwsim.evidence.validate import run_suite
from uwsim.evidence.validate.reality import arm_tilts, glides
from uwsim.scenario import load_vehicle

DATA = Path(__file__).parents[4] / "shared/reality"


def test_what_others_measured_is_met_within_the_stated_tolerances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every fifth of the trials with an arm is flown; `uwsim validate reality` flies all."""
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}: docs/inside/reality.md lists the sources of the files")
    monkeypatch.setattr(arm_tilts, "FLOWN", slice(0, None, 5))
    has_glides = (DATA / glides.FILE).is_file() and find_spec("dbdreader") is not None
    checks = run_suite("reality", tmp_path, DATA)
    groups = list(dict.fromkeys(check.group for check in checks))
    assert groups == [
        "predicted: T200 bench test",
        "predicted: RiverPro, DVL",
        "predicted: Workhorse Navigator, DVL",
        "predicted: EM 302",
        "predicted: Hinsdale, arm and tilt",
        "predicted: Hinsdale, arm and motion",
        *(["predicted: Slocum, glides"] if has_glides else []),
        "as measured: T200 bench test",
        "as measured: Workhorse Navigator, DVL",
        "as measured: Ping1D, echosounder",
        "as measured: Underwater GPS",
        "as measured: NOAA F00788",
    ]
    assert [check.name for check in checks if not check.passed] == []
    drawn = {check.group for check in checks if check.curve is not None}
    assert len(list(tmp_path.glob("reality-*.png"))) == len(drawn) == 6 + has_glides


def test_missing_data_is_reported_with_its_path_and_source(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["validate", "reality"])
    assert result.exit_code != 0 and "needs --data FOLDER" in str(result.exception)
    refused = pytest.raises(ValueError, match=f"no data in {tmp_path}")
    with pytest.warns(UserWarning, match="thrust is left out: no .*t200_10_14_16_20V.csv"), refused:
        run_suite("reality", data=tmp_path)


def test_glides_are_split_where_the_pump_turns_and_their_speeds_are_those_of_the_record() -> None:
    times_s = np.arange(0.0, 1600.0, 4.0)
    down = times_s % 800.0 < 400.0
    depth_m = np.where(down, times_s % 400.0, 400.0 - times_s % 400.0) * 0.1
    bar = depth_m * glides.WATER_KG_M3 * glides.GRAVITY_M_S2 / glides.PA_PER_BAR
    windows = glides.split(times_s, bar, np.where(down, -0.4, 0.4), np.where(down, -230.0, 230.0))
    assert set(windows.glide) == {0, 1, 2, 3}
    np.testing.assert_allclose(windows.rises_m_s, 0.1 * np.sign(windows.pumped_cm3), rtol=1e-6)
    half = glides.split(times_s, bar, np.zeros(400), np.where(down, -100.0, 230.0))
    assert (half.pumped_cm3 == 230.0).all()  # a pump that is not full is no glide


def test_a_simulated_glider_falls_by_the_root_of_its_net_weight() -> None:
    slocum = load_vehicle("slocum")
    pitches, speeds, full_n = glides.simulated_glides(slocum)
    assert (np.diff(pitches) > 0).all() and np.radians(24.0) < pitches[-1] and full_n == 2.514
    pump = slocum.thrusters["pump"]
    half = [(share, 0.5 * thrust_n) for share, thrust_n in pump.model.thrust_n]
    weaker = pump.model_copy(update={"model": pump.model.model_copy(update={"thrust_n": tuple(half)})})
    found = glides.simulated_glides(slocum.model_copy(update={"thrusters": slocum.thrusters | {"pump": weaker}}))
    at = np.radians(22.0)
    assert np.interp(at, *found[:2]) == pytest.approx(np.sqrt(0.5) * np.interp(at, pitches, speeds), rel=0.02)
