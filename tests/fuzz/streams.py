"""Readers of frames, messages and saved states, which come without a file."""

from __future__ import annotations

import json
import logging
import struct
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

CDR_TYPES = (
    "geometry_msgs/msg/Twist",
    "std_msgs/msg/String",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "rcl_interfaces/msg/ParameterEvent",
)


def named(name: str) -> Any:
    """Return a function of uwsim by its module and name."""
    module, _, names = name.partition(":")
    found = import_module(f"uwsim.{module}")
    for part in names.split("."):
        found = getattr(found, part)
    return found


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


@cache
def simulator_to_restore() -> tuple[Any, bytes]:
    """Return a simulator with a failsafe, faults and an estimate, and the state to which it returns."""
    from uwsim.scenario import Scenario, load
    from uwsim.simulator.simulator import Simulator

    base = load("pool")
    plain = {key: getattr(base, key) for key in type(base).model_fields}
    vehicle = {**dict(base.vehicles[0]), "model": "rov", "failsafe": {"leak_then": "hold"}}
    sim = Simulator(Scenario.model_validate({**plain, "vehicles": [vehicle], "link": {"modem": "micromodem"}}))
    sim.rov.release()
    assert sim.rov.estimate is not None
    sim.faults.inject("sensor", sensor="depth", mode="stuck", for_s=100.0)
    sim.faults.inject("leak", kg_per_s=0.1)
    sim.advance(2.0)
    return sim, sim.save_state()


def saved_with(notes: str) -> bytes:
    """Return a state of that simulator with other notes, and a correct checksum."""
    from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint

    sim, _ = simulator_to_restore()
    saved: bytes = sim._core.save_state(scenario_fingerprint(sim.scenario), build_fingerprint(), notes)
    return saved


def notes(data: bytes, _: Path) -> bytes:
    """Read the notes of a saved state: refused ones change nothing, accepted ones fly on."""
    sim, begin = simulator_to_restore()
    try:
        sim.restore_state(saved_with(data.decode()))
    except ValueError:
        assert sim.save_state() == begin
        raise
    restored: bytes = sim.save_state()
    try:
        sim.step(200)
        for sensor in sim.rov.sensors.values():
            sensor.sample()
    finally:
        sim.restore_state(begin)
    return restored


def commands(data: bytes, _: Path) -> bytes:
    """Read a recording's commands, one per line, ten steps apart. A refused one changes nothing."""
    from uwsim.channels import Table
    from uwsim.recording.commands import command_from
    from uwsim.recording.replay import execute

    sim, begin = simulator_to_restore()
    table = Table(sim)
    try:
        for line in data.decode().splitlines():
            before = sim.save_state()
            try:
                execute(sim, table, command_from(line))
                sim.step(10)
            except ValueError:
                assert sim.save_state() == before, line
        return bytes(sim.save_state())
    finally:
        sim.reset(seed=0)
        sim.restore_state(begin)


def cdr(data: bytes, _: Path) -> Any:
    """Read a message of the type that the first byte selects.

    An accepted one is the same after it is written and read.
    """
    from uwsim.channels.ros.cdr import encode
    from uwsim.channels.ros.messages import from_bytes

    if not data:
        return None
    name = CDR_TYPES[data[0] % len(CDR_TYPES)]
    written = bytes(encode(from_bytes(data[1:], name)))
    assert bytes(encode(from_bytes(written, name))) == written
    return written


def frames(data: bytes, _: Path) -> None:
    """Read the frames of one rosbridge client, one per line: text, or CBOR in hexadecimal digits after a #."""
    from uwsim.bridges.rosbridge import Limits
    from uwsim.bridges.rosbridge.graph import LOGGER, Graph
    from uwsim.bridges.rosbridge.session import Session

    unforeseen = _Warnings()
    LOGGER.addHandler(unforeseen)
    graph = Graph()
    session = Session(graph, "/guest", limits=Limits(names=8, replies=20, fragmented_messages=2, open_calls=4))
    try:
        for frame in _lines(data):
            session.receive(frame)
        session.close()
    finally:
        LOGGER.removeHandler(unforeseen)
    assert not unforeseen.texts, unforeseen.texts
    assert not graph.topics and not graph.services and not graph.nodes


class _Warnings(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(self.format(record))


def _lines(data: bytes) -> Iterator[str | bytes]:
    for line in data.split(b"\n"):
        if line.startswith(b"#"):
            digits = bytes(byte for byte in line if byte in b"0123456789abcdef")
            yield bytes.fromhex(digits[: len(digits) // 2 * 2].decode())
        else:
            yield line.decode("utf-8", errors="replace")


def depth_string(data: bytes, _: Path) -> bytes:
    from uwsim import _core

    beams = data[0] % 16 if data else 0
    return bytes(np.asarray(_core.decode_depth_string(data[1:].decode("latin-1"), beams, 54.9)))


def ping(data: bytes, _: Path) -> Any:
    """Read the messages of a program of a Ping1D or Ping360: they are read alike after they are written."""
    wire, found = import_module("uwsim.bridges.ping_protocol.wire"), []
    for message in wire.Reader().read(data):
        with suppress(ValueError):
            found.append(message.values)
            again = wire.Reader().read(wire.encoded(message.number, found[-1], source=message.source))
            assert [*again] == [message]
    return repr(found)


@cache
def _world() -> Any:
    return import_module("uwsim").Simulator("cove")


def a50(data: bytes, _: Path) -> Any:
    """Answer the commands of a program of a DVL A50, one a line, and look at the DVL after each."""
    name = next(name for name, sensor in _world().rov.sensors.items() if sensor.kind == "dvl")
    live = SimpleNamespace(simulator=_world(), time_ns=0)
    dvl = named("bridges.a50.dvl:A50")(live, _world().rov.name, name, None, "")
    found = [(dvl.answer(line), json.dumps(dvl._look(_world()), allow_nan=False)) for line in data.splitlines()]
    return json.dumps([answer for answer, _ in found])  # reports have the time of day


def upload(data: bytes, _: Path) -> Any:
    """Take an upload of a mission, a fence or rally points over MAVLink."""
    dialect, said, sent = import_module("pymavlink.dialects.v20.ardupilotmega"), [], []  # type: ignore[var-annotated]
    home, rov = named("bridges.mavlink.vehicle:HOME"), _world().rov
    craft = SimpleNamespace(home=home, vehicle=rov, send_text=said.append, pictures=None, launch_world_m=np.zeros(3))
    fence = named("bridges.mavlink.fence:FenceKeeper")(craft, named("bridges.mavlink.settings:Settings")())
    outputs, checked = SimpleNamespace(refusal=lambda *_: None), named("missions.items:checked")
    store = named("bridges.mavlink.missions:MissionStore")(
        dialect.MAVLink(None), lambda *each: sent.append(each), said.append, deque(),
        lambda item: checked(item, craft, outputs), fence,
    )  # fmt: skip
    kind = number = 0
    rows = named("base.texts.json_text:json_value")(data, "rows")
    for row in rows if isinstance(rows, list) else ():
        try:
            if len(row) == 2:
                (kind, count), number = row, 0
                message = dialect.MAVLink_mission_count_message(1, 1, count, kind)
            else:
                head, number = (1, 1, number, *row[:2], 0, 1), number + 1
                message = dialect.MAVLink_mission_item_int_message(*head, *row[2:], kind)
            message = dialect.MAVLink(None).decode(bytearray(message.pack(dialect.MAVLink(None))))
        except (TypeError, ValueError, OverflowError, struct.error):
            raise ValueError("cannot be sent") from None
        getattr(store, f"on_{message.get_type().lower()}")("station", message)
    return repr((store.items, said, len(sent)))


def mesh_upload(data: bytes, folder: Path) -> Any:
    """Take an upload of a mesh in parts, one a line."""
    meshes = named("operator.station.editor.meshes:Meshes")(folder)
    made = [meshes.receive(named("base.texts.json_text:json_object")(line, "part")) for line in data.splitlines()]
    return repr([(folder / each["mesh"]).read_bytes() for each in made if each["mesh"]])
