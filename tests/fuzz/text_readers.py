"""Readers of JSON, robots, packets, thrusters' sheets, and files of `uwsim vehicle identify` and `uwsim exercise`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np


def json_text(data: bytes, _: Path) -> str:
    """Read a JSON text, whose numbers the checks of services and files accept or refuse without other errors."""
    from uwsim.base.arguments import is_number
    from uwsim.base.texts.json_text import json_value

    value = json_value(data, "text")
    for each in value if isinstance(value, list) else value.values() if isinstance(value, dict) else [value]:
        assert not is_number(each) or float(each) == each or abs(each) > 2**53
    return repr(value)


def moos(data: bytes, _: Path) -> bytes:
    """Read what a MOOSDB sends. Accepted packets are read alike after they are written."""
    from uwsim.bridges.moos.wire import PacketReader, encoded

    read = list(PacketReader().read(data))
    written = encoded(read)
    assert encoded(PacketReader().read(written)) == written
    return written


def imc(data: bytes, _: Path) -> bytes:
    """Read what a system that speaks IMC sends, and one packet with its check sum mended.

    Accepted packets are read alike after they are written.
    """
    from uwsim.bridges.imc.wire import FORMATS, SYNC, ImcError, Message, PacketReader, crc16, decoded, encoded

    def written(found: list[Message]) -> bytes:
        return b"".join(encoded(each) for each in found if each.name in FORMATS)

    reader, found = PacketReader(), []
    try:
        found.extend(reader.read(data))
    except ImcError:  # too many bytes that are none; what came before them was accepted
        if not found:
            raise
    with suppress(ImcError):
        found.append(decoded(data[:-2] + crc16(data[:-2]).to_bytes(2, "little" if data[:2] == SYNC else "big")))
    once = written(found)
    assert written(list(PacketReader().read(once))) == once
    return once


def motion_log(suffix: str) -> Callable[[bytes, Path], Any]:
    """Return a reader of a log for `uwsim vehicle identify`, as far as its division into segments."""

    def read(data: bytes, folder: Path) -> list[bytes]:
        from uwsim.evidence.identification.flown import parts_of
        from uwsim.exchange.logs.motion_log import Mapping, read_log

        effort = ["e", *[None] * 5]
        columns = {"time_s": "t", "position_m": [*"xyz"], "orientation_xyzw": [*"abcd"], "effort": effort}
        chosen = Mapping.model_validate(columns) if suffix == ".csv" else None
        log = read_log(_written(folder / f"log{suffix}", data), chosen)
        assert np.allclose(np.linalg.norm(log.orientation_xyzw, axis=1), 1.0)
        assert np.isfinite(log.times_s).all() and len(parts_of(log, 29, 60.0, None)) <= len(log.times_s)
        return [log.times_s.tobytes(), log.position_m.tobytes(), log.effort_times_s.tobytes(), log.efforts.tobytes()]

    return read


def real_flight(suffix: str, columns: str | None = None) -> Callable[[bytes, Path], Any]:
    """Return a reader of the log of a real flight, as far as the motion and commands of a vehicle."""

    def read(data: bytes, folder: Path) -> list[bytes]:
        from uwsim.recording.real_flights.read import read_flight

        return _of_flight(read_flight(_written(folder / f"dive{suffix}", data), columns), "bluerov2_heavy")

    return read


def _of_flight(log: Any, vehicle: str) -> list[bytes]:
    """Return what a log and its motion as a vehicle's have to note."""
    from uwsim.recording.real_flights.motion import motion_of
    from uwsim.scenario import load_vehicle

    for each in log.series.values():
        assert (np.diff(each.times_s) > 0).all() and not np.isinf(each.values).any()
    said = [*log.notes(), *(text for _, text in log.events)]
    with suppress(ValueError):
        motion, notes = motion_of(log, load_vehicle(vehicle))
        assert np.isfinite(motion.efforts).all() and np.abs(motion.efforts).max() <= 1.0
        assert np.allclose(np.linalg.norm(motion.orientation_xyzw, axis=1), 1.0)
        said += notes
    return [line.encode(errors="replace") for line in said]


def glider(data: bytes, folder: Path) -> list[bytes]:
    """Read what dbdreader gives of a glider's log, times and values by name, here from JSON.

    The library is GPL, so that it is no dependency.
    """
    from uwsim.base.texts.json_text import json_object
    from uwsim.exchange.logs.glider_log import flight_of

    tables = json_object(data, "log")

    class Dbd:
        def get(self, name: str) -> tuple[Any, Any]:
            """Return the times and values of a name. Raises LookupError."""
            times_s, values = (np.array(each, float) for each in tables[name][:2])
            if times_s.ndim != 1 or times_s.shape != values.shape:
                raise LookupError(name)  # the library gives equally many of both
            return times_s, values

    try:
        log = flight_of(folder / "dive.dbd", Dbd(), LookupError)
    except TypeError as error:
        raise ValueError(str(error)) from None
    return _of_flight(log, "slocum")


def robot(module: str, function: str, suffix: str) -> Callable[[bytes, Path], str]:
    """Return a reader of a robot's description, as far as its vehicles' masses."""

    def read(data: bytes, folder: Path) -> str:
        found = getattr(import_module(f"uwsim.exchange.robots.{module}"), function)(
            _written(folder / f"robot{suffix}", data)
        )
        for each in found.robots:
            if each.model is None:
                whole = each.whole()
                assert whole.mass_kg > 0.0 and np.isfinite(whole.centre_m).all()
        return repr((found.notes, found.obstacles, [each.thrusters for each in found.robots]))

    return read


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path
