"""A film of how a recorded survey's map grew."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.own_files import require_own
from uwsim.figures.map_film import FILMS, MapFilm, write_film
from uwsim.flight.map_growth import growth_row
from uwsim.flight.ping_log import PingLog
from uwsim.flight.vehicle_chain import survey_area_m
from uwsim.mapping.map_filler import MapFiller
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.ping_channel import NAME
from uwsim.recording.reader import Recording
from uwsim.recording.replay import new_simulator
from uwsim.recording.survey_from import repeated, request_of


def film_of(recording: Recording, out: Path, *, pictures: int = 60, seconds: float = 12.0, width: int = 640) -> int:
    """Write a film of the map beside the truth, with its mean distance from the true surface; return its pictures.

    pictures: at equal numbers of pings. width: of the truth and of the map [pixels]. Raises ValueError or OSError.
    """
    if out.suffix not in FILMS:
        raise ValueError(f"film '{out}': must end in {' or '.join(FILMS)}")
    require_own(out)
    if recording.start.kind != SURVEY:
        raise ValueError(f"recording '{recording.path}': must be that of a survey or of a mission with a map")
    sim, request = new_simulator(recording), request_of(recording)
    area, pings = survey_area_m(sim), recording.info(NAME).message_count
    if area is None or not pings:
        raise ValueError(f"recording '{recording.path}': has no {'pings' if area is not None else 'survey area'}")
    film = MapFilm(sim.world, sim.scene, area, request.voxel_m or 1.0, width)
    due = set(np.linspace(pings, 0, pictures, endpoint=False).round().astype(int).tolist())
    begun: list[int] = []

    def seen(filler: MapFiller, log: PingLog, time_ns: int) -> None:
        begun.append(time_ns)
        if len(begun) in due:
            path, time_s = np.array(log.positions_m), (time_ns - begun[0]) * 1e-9
            filler.when_mapped(lambda: show(filler, path, time_s))

    def show(filler: MapFiller, path: Any, time_s: float) -> None:
        row = growth_row(filler.occupancy, sim, time_s)
        minutes, seconds_left = divmod(round(time_s), 60)
        value = "" if row is None else f", {row.distance_mean_m:.3f} m from the truth"
        film.add(filler.occupancy.occupied_voxels(), path, f"map after {minutes}:{seconds_left:02}{value}")

    repeated(recording, sim, request, seen)
    write_film(out, film.pictures, seconds)
    return len(film.pictures)
