"""The readers of bytes from outside, by name: each returns the content, or refuses it with a documented error.

Libraries are imported where they are used, so that a fuzzer instruments only those that it attacks.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tests.fuzz import charts, fields, others, surveys, text_readers

REFUSED = (ValueError, OSError)
"""The errors that a reader may raise: the command line turns either into one line."""

FLIGHT_COLUMNS = "t = time [s], h = heading [deg], d = depth [m], a = servo1 [us], b = servo2 [us]"
CDR_TYPES = (
    "geometry_msgs/msg/Twist",
    "std_msgs/msg/String",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "rcl_interfaces/msg/ParameterEvent",
)


class Values(NamedTuple):
    """How the values of an input are read, and written back."""

    read: Callable[[bytes], Any]
    write: Callable[[Any], bytes]


@dataclass(frozen=True)
class Reader:
    """A reader of outside bytes.

    read: from bytes and a folder to write them into, to something comparable. libraries: those that a fuzzer
    instruments in addition to uwsim. has_end: whether a truncated input can be recognised, so that none may be
    accepted. values: set if inputs are also to be mutated value by value.
    """

    read: Callable[[bytes, Path], Any]
    libraries: tuple[str, ...] = ()
    has_end: Callable[[bytes], bool] = lambda data: True
    values: Values | None = None


def _cloud(suffix: str) -> Callable[[bytes, Path], Any]:
    def read(data: bytes, folder: Path) -> bytes:
        from uwsim.mapping.files import read_cloud

        return read_cloud(_written(folder / f"cloud{suffix}", data)).tobytes()

    return read


def _mesh(suffix: str) -> Callable[[bytes, Path], Any]:
    def read(data: bytes, folder: Path) -> tuple[bytes, bytes]:
        from uwsim.scenario.read.mesh_file import load_mesh

        vertices, triangles = load_mesh(_written(folder / f"mesh{suffix}", data))
        return vertices.tobytes(), triangles.tobytes()

    return read


def _raster(suffix: str) -> Callable[[bytes, Path], Any]:
    def read(data: bytes, folder: Path) -> bytes:
        from uwsim.scenario.terrains.raster import RasterTerrain

        file = _written(folder / f"terrain{suffix}", data)
        heights = RasterTerrain(source="raster", file=file, spacing_m=1.0, water_level_m=0).heights()
        return hashlib.sha256(heights).digest()

    return read


def _image(data: bytes, folder: Path) -> bytes:
    from uwsim.scenario.terrains.image import ImageTerrain

    shape = {"size_m": (20, 10), "spacing_m": 1.0, "black_m": -9, "white_m": -1}
    return ImageTerrain(source="image", file=_written(folder / "terrain.png", data), **shape).heights().tobytes()


def _profile(data: bytes, folder: Path) -> list[Any]:
    from uwsim.scenario.build.water import build_water
    from uwsim.scenario.read.validated import validated
    from uwsim.scenario.spec.water import Water

    file = _written(folder / "profile.csv", data)
    water = build_water(validated(Water, {"profile": {"kind": "table", "file": file}}), bottom_depth_m=20.0, seed=0)
    return [water.temperature_deg_c(depth_m) for depth_m in (0.0, 5.0, 20.0)]


def _track(suffix: str) -> Callable[[bytes, Path], Any]:
    def read(data: bytes, folder: Path) -> list[bytes]:
        from uwsim.campaigns.datasets.track import read_track

        track = read_track(_written(folder / f"track{suffix}", data))
        return [each.tobytes() for each in (track.times_s, track.positions_m, track.orientations_xyzw)]

    return read


def _survey_track(data: bytes, folder: Path) -> list[Any]:
    from uwsim.scoring.survey_track import SurveyTrack

    track = SurveyTrack.read(_written(folder / "track.npz", data))
    return [track.path_world_m.tobytes(), track.area_world_m.tobytes(), track.range_max_m, track.scenario_name]


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


def _notes(data: bytes, _: Path) -> bytes:
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


def _commands(data: bytes, _: Path) -> bytes:
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


def _recording(data: bytes, folder: Path) -> list[Any]:
    """Read a recording's messages and its scenario. An incomplete recording is recognised as such."""
    from uwsim import recording
    from uwsim.recording.capsule import unpack

    opened = recording.open(_written(folder / "run.mcap", data))
    if not opened.complete:
        raise ValueError("not complete")
    said = [opened.start, opened.end, opened.channels, opened.notes, opened.dropped]
    said += [repr(message.message) for message in opened.messages(*opened.channels, *opened.derived)]
    said += [opened.arrow(name).num_rows for name in opened.channels]
    return [*said, *opened.commands(), repr(unpack(opened.attachments, folder / "unpacked"))]


def _cdr(data: bytes, _: Path) -> Any:
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


def _frames(data: bytes, _: Path) -> None:
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


def _depth_string(data: bytes, _: Path) -> bytes:
    from uwsim import _core

    beams = data[0] % 16 if data else 0
    return bytes(np.asarray(_core.decode_depth_string(data[1:].decode("latin-1"), beams, 54.9)))


def _json(value: Any) -> bytes:
    return json.dumps(value, default=str).encode()


JSON = Values(json.loads, _json)
JSON_LINES = Values(
    lambda data: [json.loads(line) for line in data.splitlines()],
    lambda lines: b"\n".join(map(_json, lines if isinstance(lines, list) else [lines])),
)


def _without_end(_: bytes) -> bool:
    return False


def _has_one_solid(data: bytes) -> bool:
    """Return whether it is not a text of several solids, each of which could be the last."""
    return data.lower().count(b"endsolid") < 2


def _yaml(data: bytes) -> Any:
    from ruamel.yaml import YAML

    return YAML(typ="safe", pure=True).load(data)


YAML_VALUES = Values(_yaml, _json)  # JSON is YAML


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


READERS = {
    "map": Reader(others.file("color_tree")),
    "depth_string": Reader(_depth_string),
    "pcd": Reader(_cloud(".pcd"), ("numpy.lib.npyio",)),
    "ply": Reader(_cloud(".ply"), ("numpy.lib.npyio",)),
    "las": Reader(_cloud(".las"), ("laspy",)),
    "laz": Reader(_cloud(".laz"), ("laspy",)),
    "gsf": Reader(surveys.reader(".gsf"), ("GSFU",), has_end=_without_end),
    "kmall": Reader(surveys.reader(".kmall"), has_end=_without_end),
    "xtf": Reader(surveys.read_side_scan, ("pyxtf",), has_end=_without_end),
    "xtf_soundings": Reader(surveys.reader(".xtf"), ("pyxtf",), has_end=_without_end),
    "xyz": Reader(_cloud(".xyz"), has_end=_without_end),
    "stl": Reader(_mesh(".stl"), ("trimesh.exchange",), _has_one_solid),
    "scan_graph": Reader(others.file("scan_graph")),
    "obj": Reader(_mesh(".obj"), ("trimesh.exchange",), has_end=_without_end),
    "mesh_ply": Reader(_mesh(".ply"), ("trimesh.exchange",)),
    "off": Reader(_mesh(".off"), ("trimesh.exchange",)),
    "glb": Reader(_mesh(".glb"), ("trimesh.exchange",)),
    "gltf": Reader(_mesh(".gltf"), ("trimesh.exchange",), values=JSON),
    "fbx": Reader(_mesh(".fbx"), has_end=_without_end),
    "dae": Reader(_mesh(".dae"), has_end=_without_end),
    "asc": Reader(_raster(".asc")),
    "tif": Reader(_raster(".tif")),
    "bag": Reader(charts.chart(".bag")),
    "s102": Reader(charts.chart(".h5")),
    "gebco": Reader(charts.chart(".nc")),
    "soundings": Reader(charts.soundings, has_end=_without_end),
    "image": Reader(_image, ("PIL",)),
    "current_npz": Reader(fields.current(".npz"), ("numpy.lib", "zipfile")),
    "current_csv": Reader(fields.current(".csv"), ("csv",), has_end=_without_end),
    "cast": Reader(fields.cast, has_end=_without_end),
    "argo": Reader(fields.cast, ("scipy.io",), has_end=_without_end),
    "ocean_csv": Reader(fields.ocean, ("csv",), has_end=_without_end),
    "ocean_netcdf": Reader(fields.ocean, ("scipy.io",), has_end=_without_end),
    "scenario": Reader(others.file("scenario"), ("ruamel",), has_end=_without_end, values=YAML_VALUES),
    **{
        kind: Reader(others.file(kind), ("ruamel",), has_end=_without_end, values=YAML_VALUES)
        for kind in ("vehicle", "thruster", "sensors", "sonar", "modem")
    },
    "sweep": Reader(others.file("sweep"), ("ruamel",), has_end=_without_end, values=YAML_VALUES),
    "exercise": Reader(others.file("exercise"), ("ruamel",), has_end=_without_end, values=YAML_VALUES),
    "json": Reader(text_readers.json_text, ("json",), has_end=_without_end, values=JSON),
    "mapping": Reader(others.file("mapping"), ("ruamel",), has_end=_without_end, values=YAML_VALUES),
    "motion_csv": Reader(text_readers.motion_log(".csv"), ("csv",), has_end=_without_end),
    "motion_mcap": Reader(text_readers.motion_log(".mcap"), ("mcap", "rosbags"), has_end=_without_end),
    "dataflash": Reader(text_readers.real_flight(".BIN"), ("pymavlink.DFReader",), has_end=_without_end),
    "tlog": Reader(text_readers.real_flight(".tlog"), has_end=_without_end),
    "flight_bag": Reader(text_readers.real_flight(".bag"), ("rosbags",), has_end=_without_end),
    "glider": Reader(text_readers.glider, ("json",), values=JSON),
    "flight_csv": Reader(text_readers.real_flight(".csv", FLIGHT_COLUMNS), ("csv",), has_end=_without_end),
    "sdf": Reader(text_readers.robot("sdf", "read_sdf", ".sdf"), ("xml",)),
    "urdf": Reader(text_readers.robot("urdf", "read_urdf", ".urdf"), ("xml",)),
    "stonefish": Reader(text_readers.robot("stonefish", "read_stonefish", ".scn"), ("xml",)),
    "plan": Reader(others.file("mission"), ("json",), values=JSON),
    "waypoints": Reader(others.file("mission"), has_end=_without_end),
    "geojson": Reader(others.file("mission"), ("json",), values=JSON),
    "kml": Reader(others.file("mission"), ("xml",)),
    "kmz": Reader(others.file("kmz"), ("xml", "zipfile")),
    "moos": Reader(text_readers.moos, has_end=_without_end),
    "imc": Reader(text_readers.imc, has_end=_without_end),
    "thruster_csv": Reader(others.file("thruster_csv"), ("csv",), has_end=_without_end),
    "profile": Reader(_profile, ("csv",), has_end=_without_end),
    "track_csv": Reader(_track(".csv"), ("csv",), has_end=_without_end),
    "track_npz": Reader(_track(".npz"), ("numpy.lib", "zipfile")),
    "survey_track": Reader(_survey_track, ("numpy.lib", "zipfile")),
    "notes": Reader(_notes, ("json",), values=JSON),
    "commands": Reader(_commands, ("pydantic", "json"), has_end=_without_end, values=JSON_LINES),
    "mcap": Reader(_recording, ("mcap", "rosbags")),
    "cdr": Reader(_cdr, ("rosbags",)),
    **{
        kind: Reader(others.file(kind), ("ruamel",), has_end=_without_end, values=YAML_VALUES)
        for kind in ("prop", "team", "calibration")
    },
    "result": Reader(others.file("result"), ("json",), values=JSON),
    "unity": Reader(others.file("unity"), ("ruamel",), has_end=_without_end),
    "xacro": Reader(others.file("xacro"), ("xacro", "xml")),
    "map_bag": Reader(others.file("map_bag"), has_end=_without_end),
    "color_tree": Reader(others.file("color_tree")),
    "ping": Reader(others.ping, has_end=_without_end),
    "a50": Reader(others.a50, ("json",), has_end=_without_end, values=JSON_LINES),
    "upload": Reader(others.upload, values=JSON),
    "mesh_upload": Reader(others.mesh, has_end=_without_end, values=JSON_LINES),
    "frames": Reader(_frames, ("cbor2", "json"), has_end=_without_end, values=JSON_LINES),
}
"""The readers by the name that `tools/fuzz` takes."""
