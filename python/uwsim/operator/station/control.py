"""The pilot's actions on the simulation itself, by name: pause, step, restart, save, record and so on."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from uwsim.channels.guest import Values
from uwsim.operator.station.saves import save

if TYPE_CHECKING:
    from uwsim.operator.station.hub import Station

STEPS_MAX = 100_000
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


def _pause(station: Station, request: Values) -> None:
    station.present().live.pause()


def _resume(station: Station, request: Values) -> None:
    running = station.present()
    if running.replay is not None:
        running.replay.resume()
    else:
        running.live.resume()


def _step(station: Station, request: Values) -> None:
    steps = request.get("steps", 1)
    if isinstance(steps, bool) or not isinstance(steps, int | float) or not 1 <= steps <= STEPS_MAX or steps % 1:
        raise ValueError(f"steps = {str(steps)[:40]}: must be a whole number in [1, {STEPS_MAX}]")
    running = station.present()
    (running.live if running.replay is None else running.replay).step(int(steps))


def _speed(station: Station, request: Values) -> None:
    speed = request.get("speed")
    if isinstance(speed, bool) or not isinstance(speed, int | float):
        raise ValueError(f"speed = {str(speed)[:40]}: must be a number; 0 for as fast as possible")
    station.present().live.speed = speed or "max"


def _restart(station: Station, request: Values) -> None:
    station.rewind()


def _quit(station: Station, request: Values) -> None:
    station.quit()


def _save(station: Station, request: Values) -> str:
    target = new_path(station, request, "session")
    save(station.present(), target)
    return f"saved in {target}"


def _record(station: Station, request: Values) -> str:
    path = new_path(station, request, "flight", ".mcap")
    station.present().record(path)
    station.present().inspection.export(station.present())
    return f"recording {path}"


def _stop_recording(station: Station, request: Values) -> str:
    path = station.present().stop_recording()
    if path is None:
        raise ValueError("nothing is being recorded")
    return f"recorded in {path}; `uwsim replay {path.name}` repeats it"


def _seek(station: Station, request: Values) -> None:
    replay = station.present().replay
    if replay is None:
        raise ValueError("no flight is replayed")
    replay.seek(request.get("time_s")).result()


def _helm(station: Station, request: Values) -> str:
    return f"you have the helm, starting at {station.take_helm()}"


def new_path(station: Station, request: Values, default: str, suffix: str = "") -> Path:
    """Return a new path in the station's folder for the requested name. Raises ValueError if invalid or existing."""
    name = request.get("name", default)
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise ValueError(f"name = {str(name)[:40]!r}: must have 1 to 64 of A-Z a-z 0-9 _ . -")
    path = station.folder / (name if name.endswith(suffix) else name + suffix)
    if path.exists():
        raise ValueError(f"'{path.name}' already exists: choose another name")
    return path


CONTROLS: dict[str, Callable[[Station, Values], str | None]] = {
    "pause": _pause,
    "resume": _resume,
    "step": _step,
    "speed": _speed,
    "restart": _restart,
    "quit": _quit,
    "save": _save,
    "record": _record,
    "stop_recording": _stop_recording,
    "seek": _seek,
    "helm": _helm,
}
OF_REPLAYS = ("seek", "helm")
NOT_OF_REPLAYS = ("restart", "save", "record", "stop_recording")
