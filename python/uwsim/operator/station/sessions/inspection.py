"""Inspection notes and the comment in pictures, which are issued as commands and exported next to the recording."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.commands import COMMENT, NOTE, require_note
from uwsim.base.commands.command import item
from uwsim.base.own_files import remove_own_file
from uwsim.base.quaternions import matrix, product
from uwsim.channels.guest import Values
from uwsim.instruments.cameras.image_file import encode_png
from uwsim.operator.station.views.snapshots import Snapshots
from uwsim.recording import Recorder
from uwsim.scenario.georeference import georeference
from uwsim.simulator.failures import Event
from uwsim.simulator.failures.events import comment_of, notes_of
from uwsim.simulator.simulator import Simulator

PLACES = ("view", "vehicle")
TIMEOUT_S = 10.0
FAR_M = 20.0  # from the vehicle; farther away, the bed may be much higher or lower than below the vehicle
STEEP = math.sin(math.radians(10.0))  # minimum angle between a camera's axis and the bed
COLUMNS = (
    "number", "time_s", "vehicle", "category", "text", "east_m", "north_m", "depth_m", "longitude_deg", "latitude_deg",
    "picture",
)  # fmt: skip
PICTURE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}\.png")
FORMULA = ("=", "+", "-", "@")  # characters with which a formula begins in a spreadsheet


class Inspection:
    """The notes of a running simulator. recorder: returns the current one, if any. folder: where files are written.

    The files are NAME-notes.csv, NAME-notes.geojson, NAME-note-1.png and so on. NAME is the name of the current
    recording or, if there is none, of the scenario. The files include notes that a restart has removed from the run.
    """

    def __init__(self, snapshots: Snapshots, recorder: Callable[[], Recorder | None], folder: Path) -> None:
        self._snapshots, self._live, self._recorder, self.folder = snapshots, snapshots.live, recorder, folder
        self._lock = threading.Lock()
        self._kept: dict[str, tuple[str, list[Event]]] = {}  # by recording: NAME, and the notes in its files

    def listed(self) -> list[Values]:
        """Return the notes, except comments, in the page's format, with positions in odom."""
        origin_m = self._snapshots.table.sources[0].origin_m
        found = [event for event in notes_of(self._live.simulator.events) if event.values["category"] != COMMENT]
        return [
            {
                "number": k, "time_s": event.time_s, "vehicle": event.vehicle, "category": event.values["category"],
                "text": event.values["text"], "picture": event.values["picture"],
                "position_m": None if (place := event.values["position_world_m"]) is None
                else (np.asarray(place) + origin_m).tolist(),
            }
            for k, event in enumerate(found, 1)
        ]  # fmt: skip

    def set_comment(self, request: Values) -> str:
        """Replace the comment shown in pictures. Raises ValueError."""
        text, category = _text(request), COMMENT
        require_note(text, category, "")
        with self._lock:
            self._write(self._vehicle(request), text=text, category=category)
        return ""

    def add(self, request: Values) -> str:
        """Add a note, with a picture if the request names a camera's view; return a sentence about its position."""
        text, category = _text(request), str(request.get("category"))
        require_note(text, category, "")
        if category == COMMENT:
            raise ValueError("category = 'comment': set a comment instead")
        place = request.get("place") or "vehicle"
        if place not in PLACES:
            raise ValueError(f"place = {str(place)[:40]!r}: must be one of {', '.join(PLACES)}")
        vehicle, view = self._vehicle(request), request.get("view") or ""
        with self._lock:
            rgb, panel = self._seen(vehicle, view)
            position_world_m, where = self._placed(vehicle, str(view), panel, place == "view")
            picture = ""
            if rgb is not None:
                self.folder.mkdir(parents=True, exist_ok=True)
                picture = self._picture_name()
                text_of = self._snapshots.described(
                    str(view), panel, comment_of(self._live.simulator.events), note=text
                )
                write_atomically(self.folder / picture, encode_png(rgb, text=text_of))
            try:
                self._write(
                    vehicle, text=text, category=category, picture=picture,
                    position_world_m=None if position_world_m is None else position_world_m.tolist(),
                )  # fmt: skip
            except BaseException:
                if picture:
                    remove_own_file(self.folder / picture)
                raise
        return where

    def picture(self, name: str) -> bytes:
        """Return a note's picture. Raises ValueError or OSError."""
        known = {event.values["picture"] for event in notes_of(self._live.simulator.events)}
        if name not in known or not PICTURE_NAME.fullmatch(name):
            raise ValueError(f"'{name[:60]}' is no note's picture")
        return (self.folder / name).read_bytes()

    def file(self, suffix: str) -> bytes:
        """Return the notes of the run so far in one of FORMATS."""
        return FORMATS[suffix](self._live.simulator, notes_of(self._live.simulator.events))

    def export(self) -> None:
        """Write the files. Raises OSError."""
        name, notes = self._files()
        notes += [event for event in notes_of(self._live.simulator.events) if event not in notes]
        if not notes:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        for suffix, make in FORMATS.items():
            write_atomically(self.folder / f"{name}-notes.{suffix}", make(self._live.simulator, notes))

    def _write(self, vehicle: str, **values: Any) -> None:
        self._live.command(NOTE, vehicle=vehicle, **values).result(TIMEOUT_S)
        self.export()

    def _files(self) -> tuple[str, list[Event]]:
        recorder = self._recorder()
        key = "" if recorder is None else str(recorder.path)
        if key not in self._kept:
            stem = self._live.simulator.scenario.name if recorder is None else recorder.path.stem
            stem = re.sub(r"[^A-Za-z0-9_.-]", "_", stem)[:60] or "run"
            names = [stem, *(f"{stem}-{k}" for k in range(2, 10_000))]
            taken_names = {name for name, _ in self._kept.values()}
            free = (n for n in names if n not in taken_names and not (self.folder / f"{n}-notes.csv").exists())
            self._kept[key] = (next(free), [])
        return self._kept[key]

    def _picture_name(self) -> str:
        name, notes = self._files()
        numbers = range(len(notes) + 1, len(notes) + 100_000)
        free = (f"{name}-note-{k}.png" for k in numbers if not (self.folder / f"{name}-note-{k}.png").exists())
        return next(free)

    def _seen(self, vehicle: str, view: object) -> tuple[NDArray[np.uint8] | None, Values]:
        """Return a picture of a view, or None if unavailable, and the panel. Raises ValueError for an unknown view."""
        if view:
            shown, arrivals = self._snapshots.views.view(view), self._snapshots.arrivals
            if arrivals is None or shown.name not in arrivals or arrivals.has_come(shown.name):
                return self._snapshots.picture(view)
        return None, self._snapshots.panel(vehicle)  # over a link, a note need not wait for a picture

    def _placed(
        self, vehicle: str, view: str, panel: Values, wants_view: bool
    ) -> tuple[NDArray[np.float64] | None, str]:
        """Return a note's position in the world, (3,) or None if unknown, and a sentence about the position."""
        own_m = np.asarray(panel["position"], np.float64) - self._snapshots.table.sources[0].origin_m
        if not np.isfinite(own_m).all():
            return None, "Noted without a position: the vehicle does not know where it is"
        if not wants_view:
            return own_m, "Noted at the vehicle's position"
        shown = self._snapshots.views.views.get(view)
        if shown is None or shown.vehicle != vehicle or shown.kind != "camera":
            return own_m, "Noted at the vehicle's position: the large view is not from an onboard camera"
        body_from_camera = shown.camera.mounting_xyzw()
        offset_m = looked_at(
            panel["orientation"], body_from_camera, shown.camera.mount.position_m, panel["distance_to_seabed"]
        )
        if offset_m is None:
            return own_m, "Noted at the vehicle's position: the bed in front of its camera is unknown"
        return (
            own_m + offset_m,
            f"Noted {float(np.linalg.norm(offset_m)):.1f} m from the vehicle, where its camera looks",
        )

    def _vehicle(self, request: Values) -> str:
        name = request.get("vehicle")
        item(self._live.vehicles, name, "vehicle")
        return str(name)


def notes_csv(sim: Simulator, notes: list[Event]) -> bytes:
    """Return notes as CSV, with positions in the world frame and, if the world is located on Earth, in WGS 84."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in _rows(sim, notes):
        if str(row["text"]).startswith(FORMULA):
            row["text"] = f"'{row['text']}"
        writer.writerow({key: "" if value is None else value for key, value in row.items()})
    return text.getvalue().encode()


def notes_geojson(sim: Simulator, notes: list[Event]) -> bytes:
    """Return notes as GeoJSON (RFC 7946), with points in WGS 84 if the world is located on Earth."""
    features = [
        {
            "type": "Feature",
            "geometry": None
            if row["longitude_deg"] is None
            else {"type": "Point", "coordinates": [row["longitude_deg"], row["latitude_deg"], -row["depth_m"]]},
            "properties": {key: value for key, value in row.items() if not key.endswith("itude_deg")},
        }
        for row in _rows(sim, notes)
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=1).encode() + b"\n"


FORMATS = {"csv": notes_csv, "geojson": notes_geojson}


def _rows(sim: Simulator, notes: list[Event]) -> list[dict[str, Any]]:
    places = [event.values["position_world_m"] for event in notes]
    degrees = _degrees(sim, places)
    rows = []
    for k, (event, place, (longitude, latitude)) in enumerate(zip(notes, places, degrees, strict=True), 1):
        east, north, up = (None, None, None) if place is None else (round(value, 3) for value in place)
        values = (
            k, event.time_s, event.vehicle, event.values["category"], event.values["text"], east, north,
            None if up is None else 0.0 - up, longitude, latitude, event.values["picture"],
        )  # fmt: skip
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def _degrees(sim: Simulator, places: list[Any]) -> list[tuple[float | None, float | None]]:
    """Return the longitude and latitude (WGS 84) of each place, or None for both if they are unknown."""
    earth = georeference(sim.scenario)
    found: list[tuple[float | None, float | None]] = [(None, None)] * len(places)
    known = [k for k, place in enumerate(places) if place is not None]
    if earth.crs is None or not known:
        return found
    for k, (latitude, longitude) in zip(known, earth.degrees([places[k] for k in known]).tolist(), strict=True):
        found[k] = (round(longitude, 8), round(latitude, 8))
    return found


def looked_at(
    world_from_body_xyzw: Any, body_from_camera_xyzw: Any, mount_m: Any, altitude_m: float
) -> NDArray[np.float64] | None:
    """Return the point where a camera's axis meets the bed, relative to the vehicle, (3,), in world axes.

    mount_m: the position (3,) of the camera on the body. altitude_m: the height above the bed, which is assumed to be
    flat and level. Returns None if the altitude is unknown, or the axis is less than 10 degrees below the horizontal or
    meets the bed more than 20 m away.
    """
    axis = matrix(product(world_from_body_xyzw, body_from_camera_xyzw))[:, 0]
    mount = matrix(world_from_body_xyzw) @ np.asarray(mount_m, np.float64)
    height_m = altitude_m + float(mount[2])
    if not (math.isfinite(height_m) and height_m > 0.0 and -axis[2] > STEEP):
        return None
    found: NDArray[np.float64] = mount + axis * (height_m / -float(axis[2]))
    return found if float(np.linalg.norm(found)) <= FAR_M else None


def _text(request: Values) -> str:
    text = request.get("text") or ""
    if not isinstance(text, str):
        raise ValueError(f"text = {text!r:.40}: must be text")
    return " ".join(text.split())
