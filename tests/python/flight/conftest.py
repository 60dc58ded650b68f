"""A pool with a short survey, and that survey, flown whole once for all tests of flights."""

from pathlib import Path

import pytest

from uwsim.flight.record import FlightRecord
from uwsim.flight.survey import run_survey
from uwsim.flight.terminal import Silent
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario


@pytest.fixture(scope="session")
def small_pool(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a pool whose survey has three short lanes."""
    pool, path = load("pool"), tmp_path_factory.mktemp("world") / "small_pool.yaml"
    area_m = ((-4.0, -3.0), (0.0, -3.0), (0.0, 1.0), (-4.0, 1.0))
    write_scenario(path, pool.model_copy(update={"survey": pool.survey.model_copy(update={"area_m": area_m})}))
    return path


@pytest.fixture(scope="session")
def surveyed(small_pool: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[FlightRecord, Path]:
    """Return the record of the small pool's survey and its folder."""
    out = tmp_path_factory.mktemp("surveyed")
    return run_survey(small_pool, out, report="json", screen=Silent()), out
