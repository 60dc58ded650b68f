"""Pictures that a mission's triggers take: files in a folder, and a table of where each was taken."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.own_files import mark, require_own
from uwsim.mapping.files.georeference import Place
from uwsim.missions.own_vehicle import OwnVehicle

TABLE = "pictures.csv"
COLUMNS = (
    "file", "time_s", "latitude_deg", "longitude_deg", "depth_m", "heading_deg", "pitch_deg", "roll_deg", "item",
)  # fmt: skip


class Picture(NamedTuple):
    """A picture that was taken. number: from 0. values: its row of the table."""

    number: int
    values: dict[str, Any]


class PictureFolder:
    """Takes pictures with a vehicle's first camera into a folder, which is made with the first one.

    Pictures that are there already stay, and the table goes on. place: the world's location on Earth. The position is
    the vehicle's estimate; heading from north, pitch nose up, roll to starboard. Raises FileExistsError for a table of
    others.
    """

    def __init__(self, folder: Path, place: Place) -> None:
        self._folder, self._place, self._count = folder, place, 0
        require_own(folder / TABLE)

    def take(self, vehicle: OwnVehicle, item: int) -> Picture:
        """Take a picture for an item. Raises OSError."""
        from uwsim.instruments.cameras.image_file import write_image

        name = next(iter(vehicle.cameras))
        picture, pose = vehicle.cameras[name].capture(), vehicle.pose
        while (file := self._folder / f"{vehicle.name}-{name}-{self._count:05d}.png").exists():
            self._count += 1
        self._folder.mkdir(parents=True, exist_ok=True)
        write_image(file, picture.rgb)
        latitude, longitude = self._place.degrees(pose.position_world_m)
        ahead, left, up = pose.world_from_body[:3, :3].T
        angles = (
            math.degrees(math.atan2(ahead[0], ahead[1])) % 360,
            math.degrees(math.asin(min(max(ahead[2], -1.0), 1.0))),
            math.degrees(math.atan2(left[2], up[2])),
        )
        numbers = (vehicle.time_s, latitude, longitude, -pose.position_world_m[2], *angles)
        texts = (file.name, *(f"{value:.{k}f}" for value, k in zip(numbers, (3, 9, 9, 3, 3, 3, 3), strict=True)), item)
        require_own(table := self._folder / TABLE)
        with table.open("a", newline="") as stream:
            csv.writer(stream).writerows([texts] if stream.tell() else [COLUMNS, texts])
        mark(table)
        self._count += 1
        values = dict(zip(COLUMNS, (file.name, *(float(value) for value in numbers), item), strict=True))
        vehicle.log("picture", **values)
        return Picture(self._count - 1, values)
