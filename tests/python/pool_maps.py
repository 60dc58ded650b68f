"""Small maps of the pool, and helpers that run `uwsim map` on them in this process."""

from pathlib import Path

import numpy as np
from PIL import Image
from typer.testing import CliRunner

from uwsim import _core
from uwsim.cli.map import app
from uwsim.mapping import OccupancyMap
from uwsim.scenario import build_world, load
from uwsim.scoring.survey_track import SurveyTrack

VOXEL_M, RANGE_M = 0.25, 5.0


def write_pool_maps(folder: Path) -> Path:
    """Write pool.bt, pool.ot and track.npz for the whole pool, and part.bt for a part of it; return the folder."""
    scenario = load("pool")
    rays = _core.RayScene(build_world(scenario))
    area = np.asarray(scenario.survey.area_m)
    low, high = area.min(axis=0), area.max(axis=0)
    places = [(x, y, -1.5) for x in np.linspace(low[0], high[0], 9) for y in np.linspace(low[1], high[1], 9)]
    whole, part = OccupancyMap(VOXEL_M), OccupancyMap(VOXEL_M)
    random = np.random.default_rng(3)
    for index, place in enumerate(places):
        directions = random.normal(0.0, 1.0, (3000, 3)) * [1.0, 1.0, 0.5] - [0.0, 0.0, 1.0]
        ranges = rays.cast(np.array([place]), directions, RANGE_M).ranges_m
        hit = np.isfinite(ranges)
        unit = directions / np.linalg.norm(directions, axis=1)[:, None]
        points = (np.array(place) + unit[hit] * ranges[hit, None]).astype(np.float32)
        whole.insert_scan(points, place, RANGE_M)
        if index < 30:
            part.insert_scan(points, place, RANGE_M)
    whole.write(folder / "pool.bt")
    whole.write(folder / "pool.ot")
    part.write(folder / "part.bt")
    OccupancyMap(VOXEL_M).write(folder / "empty.bt")
    OccupancyMap(VOXEL_M).write(folder / "empty.ot")
    OccupancyMap(0.5).write(folder / "coarse.bt")
    SurveyTrack(np.array(places), area, RANGE_M).write(folder / "track.npz")
    return folder


def uwsim_map(*arguments: object) -> str:
    """Run `uwsim map` with these arguments; return its output."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def error_of(*arguments: object) -> str:
    """Run `uwsim map`, which must fail; return its error message."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert isinstance(result.exception, ValueError | OSError), result.output
    return str(result.exception)


def read_figure(path: Path) -> np.ndarray:
    """Read an image (height, width, 3), checking that it is not a single colour."""
    image = np.asarray(Image.open(path).convert("RGB"))
    assert image.std() > 5.0, "the image is of one colour"
    return image
