"""All pictures of a survey, in the order in which the report shows them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.survey.error_picture import where_it_is_wrong
from uwsim.survey.fan_picture import sonar_fan
from uwsim.survey.map_picture import map_from_above
from uwsim.survey.profile_picture import depth_profile
from uwsim.survey.record import SurveyRecord
from uwsim.survey.scene_picture import truth_and_map
from uwsim.survey.score import MapScore

PICTURES = ("truth_and_map.png", "map_from_above.png", "where_it_is_wrong.png", "sonar_fan.png", "depth_profile.png")
WHERE_IT_IS_WRONG = (
    "The depth of each cell's occupied voxels against the true terrain: too deep, too shallow, and where a voxel is "
    "missing or holds no true surface. Below, how many cells keep to an error, beside what IHO S-44 allows."
)


@dataclass(frozen=True)
class Picture:
    """A PNG on disk, and what the report says of it."""

    path: Path
    title: str
    caption: str


def draw_pictures(
    folder: Path,
    world: _core.World,
    record: SurveyRecord,
    score: MapScore,
    occupied_centres_m: NDArray[np.floating],
) -> list[Picture]:
    """Draw into an existing folder what there is to draw: a survey without pings has neither fan nor profile.

    Raises OSError where it cannot.
    """
    pictures = [
        Picture(
            folder / PICTURES[0],
            "Truth and map",
            "The surveyed area cut out of the true world (left) and the occupied voxels of the map (right), seen by "
            "one camera and coloured by height. The orange line is the sonar's path, drawn over what would hide it.",
        ),
        Picture(
            folder / PICTURES[1],
            "The map from above",
            "The highest occupied voxel of each column with the sonar's path. Voxels of the true surface that were in "
            "line of sight and range of the path, but are not in the map, are marked in pink.",
        ),
        Picture(folder / PICTURES[2], "Where the map is wrong", WHERE_IT_IS_WRONG),
    ]
    truth_and_map(pictures[0].path, world, record, occupied_centres_m)
    map_from_above(pictures[1].path, record, score, occupied_centres_m)
    where_it_is_wrong(pictures[2].path, score, record.area_world_m)
    if record.sample_ping is not None:
        fan = "One ping of the survey as the sonar sent it: from above over the true seabed, and from the side."
        pictures.append(Picture(folder / PICTURES[3], "The sonar's fan", fan))
        sonar_fan(pictures[-1].path, world, record)
    if len(record.path_world_m) > 1:
        profile = "The sonar's depth along its path, and the true seabed straight below it."
        pictures.append(Picture(folder / PICTURES[4], "Depth along the path", profile))
        depth_profile(pictures[-1].path, world, record)
    return pictures
