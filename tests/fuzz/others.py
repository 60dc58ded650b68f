"""Further files and frames of others: readers for the fuzzers, and inputs with which these start."""

from __future__ import annotations

import base64
import json
import struct
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

CAMERA = b"""image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [500.0, 0.0, 310.0, 0.0, 510.0, 250.0, 0.0, 0.0, 1.0]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.01, 0.0, 0.0, 0.0]}
"""
SCENE = b"""%YAML 1.1
--- !u!1 &100\nGameObject: {m_Component: [{component: {fileID: 101}}], m_Name: wall, m_IsActive: 1}
--- !u!4 &101\nTransform: {m_GameObject: {fileID: 100}, m_LocalRotation: {x: 0, y: 0, z: 0, w: 1}, m_LocalPosition:
  {x: 1, y: 2, z: 3}, m_LocalScale: {x: 1, y: 1, z: 1}, m_Children: [], m_Father: {fileID: 0}}
--- !u!33 &102\nMeshFilter: {m_GameObject: {fileID: 100}, m_Mesh:
  {fileID: 10202, guid: 0000000000000000e000000000000000}}
--- !u!23 &103\nMeshRenderer: {m_GameObject: {fileID: 100}, m_Enabled: 1}
"""
XACRO = b"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="a"><xacro:arg name="n" default="2"/>
<xacro:property name="p" value="${2 * (1 + len([pi, 3])) if 1 == 1 else 'a'}"/><xacro:macro name="m" params="a b:=3 *c">
<link name="${a}_${str(p)[0:1]}_${max(b, 1)}"><xacro:insert_block name="c"/></link></xacro:macro>
<xacro:m a="$(arg n)"><b/></xacro:m><xacro:if value="$(eval n == 2)"><c/></xacro:if></robot>"""
TEAM = b"name: A\ncourse: reef-course\nprogram: [python3, pilot.py]\nperiod_s: 0.1\n"
RESULT = {
    "version": 1, "team": "a", "course": "b", "title": "c", "points": 9.0, "mean": 3.0, "low": 2.0, "high": 4.0,
    "passed": 1, "runs": [{"seed": 1, "score": 3.0, "time_s": 5.0, "goals": {"gate": 3.0}, "why": []}],
}  # fmt: skip
UPLOAD = [[0, 4], [0, 16, 0, 0, 0, 0, 0, 0, 0], [3, 16, 0, 0, 0, 0, 0, 0, -2], [3, 18, 1, 0, 2, 0, 9, 9, -2],
          [2, 178, 1, 0.5, 0, 0, 0, 0, 0], [1, 1], [0, 5003, 9, 1, 0, 0, 0, 0, 0]]  # fmt: skip
"""A mission and a fence of MAVLink: type and count; then of each item frame, command, parameters and place."""


def _of(name: str) -> Any:
    module, _, of = name.partition(":")
    return getattr(import_module(f"uwsim.{module}"), of)


def _xacro(path: Path) -> Any:
    """Expand macros without a process of its own, since the grammar is attacked; that makes one line of any error."""
    given = {"roots": [str(path.parent)], "packages": {}, "arguments": {}}
    try:
        return _of("exchange.robots.xacro_process:read")(str(path), given)["document"].tobytes()
    except Exception as error:
        raise ValueError(str(error)) from None


def _scene(path: Path) -> Any:
    (path.parent / "Assets").mkdir(exist_ok=True)
    project = _of("exchange.unity.project:Project")(path.parent)
    return vars(_of("exchange.unity.scene:read_scene")(project, path))


def _result(path: Path) -> Any:
    """Read a result of a course, with the digest that fits."""
    found = _of("base.texts.json_text:read_json")(path)
    if isinstance(found, dict):
        found["digest"] = _of("exercises.certified:digest_of")(found)
        path.write_text(json.dumps(found))
    table = import_module("uwsim.league.table")
    return table.table_rows(table.read_results(path.parent))


MAPPED = {"topic": None, "frame": None, "voxel_m": 0.5}
FILES: dict[str, tuple[str, str | Callable[[Path], Any]]] = {
    "scenario": ("scenario.yaml", "scenario:load"),
    "vehicle": ("part.yaml", "scenario.spec.vehicle:load_vehicle"),
    "thruster": ("part.yaml", "scenario.spec.actuator:load_thruster"),
    "sensors": ("part.yaml", "scenario.spec.sensor:load_sensors"),
    "sonar": ("part.yaml", "scenario.spec.sonar:load_sonar"),
    "modem": ("part.yaml", "scenario.spec.link:load_modem"),
    "prop": ("a.yaml", lambda path: _of("scenario.spec.prop:_prop")(path, SimpleNamespace(context={}))),
    "sweep": ("sweep.yaml", "campaigns.sweeps.spec:read_sweep"),
    "exercise": ("exercise.yaml", "exercises.exercise:load_exercise"),
    "team": ("team.yaml", lambda path: _of("league.team:load_team")(path.parent)),
    "result": ("result.json", _result),
    "calibration": ("a.yaml", "scenario.read.calibration:calibrated_fields"),
    "mapping": ("map.yaml", "exchange.logs.motion_log:read_mapping"),
    "mission": ("mission", "missions.field:read_mission_file"),
    "kmz": ("mission.kmz", "missions.field:read_mission_file"),
    "thruster_csv": ("sheet.csv", "scenario.read.spec_file:read_sheet_rows"),
    "unity": ("a.unity", _scene),
    "xacro": ("a.xacro", _xacro),
    "map_bag": ("a.bag", lambda path: _of("recording.foreign_bag:map_from_bag")(path, **MAPPED).notes),
    "scan_graph": (
        "a.graph",
        lambda path: [scan.points_world_m.tobytes() for scan in _of("mapping.files.scan_graph:read_scans")(path)],
    ),
    "color_tree": ("a.ot", lambda path: _of("mapping:OccupancyMap").read(path).to_bytes("ot")),
}
"""The name of a file, and its reader: a function, or the module and name of one."""


def file(name: str) -> Callable[[bytes, Path], Any]:
    """Return the reader of one of FILES."""
    named, read = FILES[name]

    def of(data: bytes, folder: Path) -> str:
        (path := folder / named).write_bytes(data)
        return repr((_of(read) if isinstance(read, str) else read)(path))

    return of


def ping(data: bytes, _: Path) -> Any:
    """Read the messages of a program of a Ping1D or Ping360: they are read alike after they are written."""
    wire, found = import_module("uwsim.bridges.ping.wire"), []
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
    dvl = _of("bridges.a50.dvl:A50")(live, _world().rov.name, name, None, "")
    found = [(dvl.answer(line), json.dumps(dvl._look(_world()), allow_nan=False)) for line in data.splitlines()]
    return json.dumps([answer for answer, _ in found])  # reports have the time of day


def upload(data: bytes, _: Path) -> Any:
    """Take an upload of a mission, a fence or rally points over MAVLink."""
    dialect, said, sent = import_module("pymavlink.dialects.v20.ardupilotmega"), [], []  # type: ignore[var-annotated]
    home, rov = _of("bridges.mavlink.vehicle:HOME"), _world().rov
    craft = SimpleNamespace(home=home, vehicle=rov, send_text=said.append, pictures=None, launch_world_m=np.zeros(3))
    fence = _of("bridges.mavlink.fence:FenceKeeper")(craft, _of("bridges.mavlink.settings:Settings")())
    outputs, checked = SimpleNamespace(refusal=lambda *_: None), _of("missions.items:checked")
    store = _of("bridges.mavlink.missions:MissionStore")(
        dialect.MAVLink(None), lambda *each: sent.append(each), said.append, deque(),
        lambda item: checked(item, craft, outputs), fence,
    )  # fmt: skip
    kind = number = 0
    rows = _of("base.texts.json_text:json_value")(data, "rows")
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


def mesh(data: bytes, folder: Path) -> Any:
    """Take an upload of a mesh in parts, one a line."""
    meshes = _of("operator.station.editor.meshes:Meshes")(folder)
    made = [meshes.receive(_of("base.texts.json_text:json_object")(line, "part")) for line in data.splitlines()]
    return repr([(folder / each["mesh"]).read_bytes() for each in made if each["mesh"]])


def pings() -> bytes:
    """Return messages to a Ping1D and a Ping360."""
    encoded = _of("bridges.ping.wire:encoded")
    values = {"scan_start": 0, "scan_length": 9000, "requested_id": 1211, "id": 1, "reserved": 0}
    return b"".join(encoded(number, values, source=1) for number in (1001, 6, 2000, 1400))


def parts(content: bytes) -> bytes:
    """Return an upload of a mesh in two parts, one a line."""
    half, about = len(content) // 2, {"name": "a.stl", "size": len(content)}
    cut = ((0, content[:half]), (half, content[half:]))
    rows = [{**about, "at": at, "data": base64.b64encode(data).decode()} for at, data in cut]
    return "\n".join(map(json.dumps, rows)).encode()


def colored(octree: bytes) -> bytes:
    """Return an OctoMap .ot file as a ColorOcTree."""
    header, _, body = octree.partition(b"\ndata\n")
    plain = np.frombuffer(body, np.dtype([("log_odds", "<f4"), ("children", "u1")]))
    nodes = np.zeros(len(plain), np.dtype([("log_odds", "<f4"), ("colour", "u1", 3), ("children", "u1")]))
    nodes["log_odds"], nodes["children"] = plain["log_odds"], plain["children"]
    return header.replace(b"id OcTree", b"id ColorOcTree") + b"\ndata\n" + nodes.tobytes()


def moos() -> list[bytes]:
    """Return what a MOOSDB has sent."""
    exchange = json.loads((Path(__file__).parents[1] / "python/data/moos/exchange.json").read_text())
    return [bytes.fromhex(each["bytes"]) for each in exchange if each["from"] == "MOOSDB"]


def imc() -> list[bytes]:
    """Return a packet of each message, and all of them together."""
    from uwsim.bridges.imc.wire import FORMATS, Message, encoded

    inline = {"beam_config": [("BeamConfig", {"beam_width": 0.5})], "data": b"\1\2", "list": "DVL=1", "services": "a;b"}
    packets = [
        encoded(Message(name, {field: inline[field] for field, _ in of if field in inline}, 0xD1, 1, 1.5))
        for name, (_, of) in FORMATS.items()
    ]
    return [b"".join(packets), *packets]
