"""The pilot's actions on the simulation itself, by name: pause, step, restart, save, record and so on."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from uwsim.base.arguments import is_number, is_within
from uwsim.channels.guest import Values
from uwsim.live import LiveSimulator
from uwsim.operator.station.flights.replay import Replay
from uwsim.operator.station.sessions.saves import save
from uwsim.operator.station.sessions.sessions import Sessions

STEPS_MAX = 100_000
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


def _stepped(sessions: Sessions) -> Replay | LiveSimulator:
    """Return what goes on when time does: the replay, if the simulator follows one."""
    running = sessions.present()
    return running.live if running.replay is None else running.replay


def _step(sessions: Sessions, request: Values) -> None:
    steps = request.get("steps", 1)
    if not is_within(steps, 1, STEPS_MAX, whole=True):
        raise ValueError(f"steps = {str(steps)[:40]}: must be a whole number in [1, {STEPS_MAX}]")
    _stepped(sessions).step(int(steps))


def _speed(sessions: Sessions, request: Values) -> None:
    speed = request.get("speed")
    if not is_number(speed):
        raise ValueError(f"speed = {str(speed)[:40]}: must be a number; 0 for as fast as possible")
    sessions.present().live.speed = speed or "max"


def _save(sessions: Sessions, request: Values) -> str:
    target = new_path(sessions.folder, request, "session")
    save(sessions.present(), target)
    return f"saved in {target}"


def _record(sessions: Sessions, request: Values) -> str:
    path = new_path(sessions.folder, request, "flight", ".mcap")
    running = sessions.present()
    running.record(path)
    running.inspection.export()
    return f"recording {path}"


def _stop_recording(sessions: Sessions, request: Values) -> str:
    path = sessions.present().stop_recording()
    if path is None:
        raise ValueError("nothing is being recorded")
    return f"recorded in {path}; `uwsim replay {path.name}` repeats it"


def new_path(folder: Path, request: Values, default: str, suffix: str = "") -> Path:
    """Return a new path in a folder for the requested name. Raises ValueError if invalid or existing."""
    name = request.get("name", default)
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise ValueError(f"name = {str(name)[:40]!r}: must have 1 to 64 of A-Z a-z 0-9 _ . -")
    path = folder / (name if name.endswith(suffix) else name + suffix)
    if suffix == ".py" and (path.stem in sys.stdlib_module_names or find_spec(path.stem.split(".")[0])):
        raise ValueError(f"name = '{name}': a Python module has this name, which the file would hide: choose another")
    if path.exists():
        raise ValueError(f"'{path.name}' already exists: choose another name")
    return path


CONTROLS: dict[str, Callable[[Sessions, Values], str | None]] = {
    "pause": lambda sessions, request: sessions.present().live.pause(),
    "resume": lambda sessions, request: _stepped(sessions).resume(),
    "step": _step,
    "speed": _speed,
    "restart": lambda sessions, request: sessions.rewind(),
    "begin": lambda sessions, request: sessions.present().flown.begin(),
    "quit": lambda sessions, request: sessions.quit(),
    "save": _save,
    "record": _record,
    "stop_recording": _stop_recording,
    "seek": lambda sessions, request: sessions.present().replayed.seek(request.get("time_s")).result(),
    "helm": lambda sessions, request: f"you have the helm, starting at {sessions.branch()}",
}
OF_EXERCISES = ("begin", "restart", "record", "stop_recording")
"""The controls of an exercise's pilot."""
OF_REPLAYS = ("seek", "helm")
NOT_OF_REPLAYS = ("begin", "restart", "save", "record", "stop_recording")
