"""Saved sessions. Each is a folder with the maps, the state, the scenario and its files, and the commands."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from uwsim.channels.guest import Values
from uwsim.operator.station.sessions.running import Running
from uwsim.recording.capsule import SCENARIO, pack, unpack
from uwsim.simulator.simulator import Simulator

STATE = "state"


def save(running: Running, target: Path) -> None:
    """Write a session, either completely or not at all. Raises OSError or ValueError."""
    live = running.live
    state, tick, log = live.read(lambda sim: (sim.save_state(), sim.tick, list(live.log))).result()
    commands = {"tick": tick, "commands": [_plain(entry) for entry in log]}
    contents = pack(live.simulator.scenario)
    contents |= {STATE: state, "commands.json": json.dumps(commands, indent=1).encode()}
    with TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as made:
        (folder := Path(made) / "new").mkdir()
        for name, content in contents.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        for vehicle, ping_map in running.maps.items():
            for suffix in ("bt", "ot"):  # .bt for other programs; .ot with all probabilities, to continue from
                ping_map.write(folder / f"{vehicle}.{suffix}")
        folder.rename(target)


def saved_names(folder: Path) -> list[str]:
    """Return the names of the sessions in a folder, newest first."""
    found = [path.parent for path in folder.glob(f"*/{STATE}") if (path.parent / SCENARIO).is_file()]
    return [path.name for path in sorted(found, key=lambda path: path.stat().st_mtime, reverse=True)]


def load_saved(folder: Path, threads: int | None) -> Simulator:
    """Return a session's simulator in its saved state. Raises ValueError or OSError."""
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    contents = {name: path.read_bytes() for name, path in files.items() if name == SCENARIO or "/" in name}
    sim = Simulator(unpack(contents, folder), threads=threads)
    sim.restore_state((folder / STATE).read_bytes())
    return sim


def continue_maps(running: Running, folder: Path) -> None:
    """Load the maps of a session, to which the running simulator then adds."""
    for vehicle, ping_map in running.maps.items():
        if (folder / f"{vehicle}.ot").is_file():
            ping_map.go_on_from(folder / f"{vehicle}.ot")


def _plain(entry: Any) -> Values:
    arguments = {key: v for key, v in entry.arguments.items() if not isinstance(v, bytes) and not callable(v)}
    return {"tick": entry.tick, "name": entry.name, "arguments": arguments}
