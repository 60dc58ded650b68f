"""Data that others measured: thrust, noise of instruments, a surveyed sea floor. The files are not packaged."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from uwsim.cli.program import app
from uwsim.evidence.validate import reality, run_suite

DATA = Path(__file__).parents[4] / "shared/reality"


def test_what_others_measured_is_met_within_the_stated_tolerances(tmp_path: Path) -> None:
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}: docs/inside/reality.md lists the sources of the files")
    checks = run_suite("reality", tmp_path, DATA)
    groups = list(dict.fromkeys(check.group for check in checks))
    assert groups == [
        "predicted: T200 bench test",
        "predicted: RiverPro, DVL",
        "predicted: Workhorse Navigator, DVL",
        "predicted: EM 302",
        "predicted: Hinsdale, arm and tilt",
        "predicted: Hinsdale, arm and motion",
        "as measured: T200 bench test",
        "as measured: Workhorse Navigator, DVL",
        "as measured: Ping1D, echosounder",
        "as measured: Underwater GPS",
        "as measured: NOAA F00788",
    ]
    assert [check.name for check in checks if not check.passed] == []
    assert len(list(tmp_path.glob("reality_*.png"))) == len(reality.DATA_SETS)


def test_missing_data_is_reported_with_its_path_and_source(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["validate", "reality"])
    assert result.exit_code != 0 and "needs --data FOLDER" in str(result.exception)
    refused = pytest.raises(ValueError, match=f"no data in {tmp_path}")
    with pytest.warns(UserWarning, match="thrust is left out: no .*t200_10_14_16_20V.csv"), refused:
        run_suite("reality", data=tmp_path)
