"""The readers of bytes from outside, by name: each returns the content, or refuses it with a documented error.

Libraries are imported where they are used, so that a fuzzer instruments only those that it attacks.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from tests.fuzz import streams
from tests.fuzz.streams import named

REFUSED = (ValueError, OSError)
"""The errors that a reader may raise: the command line turns either into one line."""


class Values(NamedTuple):
    """How the values of an input are read, and written back."""

    read: Callable[[bytes], Any]
    write: Callable[[Any], bytes]


def _json(value: Any) -> bytes:
    return json.dumps(value, default=str).encode()


def _yaml(data: bytes) -> Any:
    from ruamel.yaml import YAML

    return YAML(typ="safe", pure=True).load(data)


JSON = Values(json.loads, _json)
YAML_VALUES = Values(_yaml, _json)  # JSON is YAML
JSON_LINES = Values(
    lambda data: [json.loads(line) for line in data.splitlines()],
    lambda lines: b"\n".join(map(_json, lines if isinstance(lines, list) else [lines])),
)


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


def content(value: Any) -> Any:
    """Return what a reader has read, so that it can be compared."""
    if isinstance(value, np.ndarray):
        return value.tobytes()
    if is_dataclass(value) and not isinstance(value, type):
        return [content(getattr(value, field.name)) for field in fields(value)]
    if isinstance(value, Mapping):
        return [(key, content(each)) for key, each in value.items()]
    return [content(each) for each in value] if isinstance(value, list | tuple | Iterator) else repr(value)


def endless(_: bytes) -> bool:
    return False


def _has_one_solid(data: bytes) -> bool:
    """Return whether it is not a text of several solids, each of which could be the last."""
    return data.lower().count(b"endsolid") < 2


def file(
    name: str,
    read: str | Callable[[Path], Any],
    libraries: tuple[str, ...] = (),
    end: Callable[[bytes], bool] = lambda data: True,
    values: Values | None = None,
) -> Reader:
    """Return the reader of a file with this name. read: a function, or the module and name of one."""

    def of(data: bytes, folder: Path) -> Any:
        (path := folder / name).write_bytes(data)
        return content((named(read) if isinstance(read, str) else read)(path))

    return Reader(of, libraries, end, values)


def raster(path: Path) -> Any:
    """Read the heights of a raster."""
    return named("scenario.terrains.raster:RasterTerrain")(
        source="raster", file=path, spacing_m=1.0, water_level_m=0
    ).heights()


def image(path: Path) -> Any:
    """Read the heights that a picture shows."""
    shape = {"size_m": (20, 10), "spacing_m": 1.0, "black_m": -9, "white_m": -1}
    return named("scenario.terrains.image:ImageTerrain")(source="image", file=path, **shape).heights()


def water(path: Path) -> list[float]:
    """Read a measured column of water, and make a scenario's water of it."""
    spec = {"profile": {"kind": "table", "file": path}}
    valid = named("scenario.read.validated:validated")(named("scenario.spec.water:Water"), spec)
    made = named("scenario.build.water:build_water")(valid, bottom_depth_m=20.0, seed=0)
    return [each for z in (0.0, -5.0, -20.0) for each in (made.sound_speed_m_s(z), made.density_at_kg_m3(z))]


def chart(path: Path) -> list[Any]:
    """Read a chart: the scenario that is made of it."""
    out = path.with_name("made.yaml")
    made = named("exchange.charts:scenario_from_chart")(path, out, size_m=10.0)
    return [out.read_bytes(), made.depth_m]


def soundings(path: Path) -> list[Any]:
    """Read soundings as text, and grid them."""
    found, out = named("exchange.soundings:read_soundings")(path), path.with_name("made.tif")
    return [found.points, named("exchange.soundings:grid_soundings")(found, out, cell=None, crs=None), out.read_bytes()]


def raw_survey(path: Path) -> Any:
    """Read the profile and the directions of the beams of a raw survey."""
    head, swaths = named("mapping.files.swath:survey_format")(path, "--from").read(path)
    return [head.profile.depths_m, *(swath.axes for swath in swaths)]


def motion_log(path: Path) -> list[Any]:
    """Read a log for `uwsim vehicle identify`, as far as its division into segments."""
    mapping, read_log = (named(f"exchange.logs.motion_log:{each}") for each in ("Mapping", "read_log"))
    effort = ["e", *[None] * 5]
    columns = {"time_s": "t", "position_m": [*"xyz"], "orientation_xyzw": [*"abcd"], "effort": effort}
    log = read_log(path, mapping.model_validate(columns) if path.suffix == ".csv" else None)
    parts = named("evidence.identification.flown:parts_of")(log, 29, 60.0, None)
    assert np.allclose(np.linalg.norm(log.orientation_xyzw, axis=1), 1.0)
    assert np.isfinite(log.times_s).all() and len(parts) <= len(log.times_s)
    return [log.times_s, log.position_m, log.effort_times_s, log.efforts]


def real_flight(path: Path) -> list[str]:
    """Read the log of a real flight, as far as the motion and commands of a vehicle."""
    columns = "t = time [s], h = heading [deg], d = depth [m], a = servo1 [us], b = servo2 [us]"
    read = named("recording.real_flights.read:read_flight")
    return _of_flight(read(path, columns if path.suffix == ".csv" else None), "bluerov2_heavy")


def _of_flight(log: Any, vehicle: str) -> list[str]:
    """Return what a log and its motion as a vehicle's have to note."""
    for each in log.series.values():
        assert (np.diff(each.times_s) > 0).all() and not np.isinf(each.values).any()
    said = [*map(str, log.notes()), *(text for _, text in log.events)]
    with suppress(ValueError):
        model = named("scenario:load_vehicle")(vehicle)
        motion, notes = named("recording.real_flights.motion:motion_of")(log, model)
        assert np.isfinite(motion.efforts).all() and np.abs(motion.efforts).max() <= 1.0
        assert np.allclose(np.linalg.norm(motion.orientation_xyzw, axis=1), 1.0)
        said += map(str, notes)
    return said


def glider(path: Path) -> list[str]:
    """Read what dbdreader gives of a glider's log, times and values by name, here from JSON.

    The library is GPL, so that it is no dependency.
    """
    tables = named("base.texts.json_text:read_json")(path)

    class Dbd:
        def get(self, name: str) -> tuple[Any, Any]:
            """Return the times and values of a name. Raises LookupError."""
            times_s, values = (np.array(each, float) for each in tables[name][:2])
            if times_s.ndim != 1 or times_s.shape != values.shape:
                raise LookupError(name)  # the library gives equally many of both
            return times_s, values

    try:
        log = named("exchange.logs.glider_log:flight_of")(path, Dbd(), LookupError)
    except TypeError as error:
        raise ValueError(str(error)) from None
    return _of_flight(log, "slocum")


def robot(path: Path, read: str) -> Any:
    """Read a robot's description, as far as its vehicles' masses."""
    found = named(f"exchange.robots.{read}")(path)
    for each in found.robots:
        if each.model is None:
            whole = each.whole()
            assert whole.mass_kg > 0.0 and np.isfinite(whole.centre_m).all()
    return repr((found.notes, found.obstacles, [each.thrusters for each in found.robots]))


def xacro(path: Path) -> Any:
    """Expand macros without a process of its own, since the grammar is attacked; that makes one line of any error."""
    given = {"roots": [str(path.parent)], "packages": {}, "arguments": {}}
    try:
        return named("exchange.robots.xacro_process:read")(str(path), given)["document"]
    except Exception as error:
        raise ValueError(str(error)) from None


def unity_scene(path: Path) -> Any:
    """Read a scene of Unity."""
    (path.parent / "Assets").mkdir(exist_ok=True)
    project = named("exchange.unity.project:Project")(path.parent)
    return vars(named("exchange.unity.scene:read_scene")(project, path))


def result(path: Path) -> Any:
    """Read a result of a course, with the digest that fits."""
    found = named("base.texts.json_text:read_json")(path)
    if isinstance(found, dict):
        found["digest"] = named("exercises.certified:digest_of")(found)
        path.write_text(json.dumps(found))
    table = import_module("uwsim.league.table")
    return table.table_rows(table.read_results(path.parent))


def map_of_bag(path: Path) -> Any:
    """Make a map of a bag."""
    return named("recording.foreign_bag:map_from_bag")(path, topic=None, frame=None, voxel_m=0.5).notes


def recording(path: Path) -> list[Any]:
    """Read a recording's messages and its scenario. An incomplete recording is recognised as such."""
    opened = named("recording:open")(path)
    if not opened.complete:
        raise ValueError("not complete")
    said = [opened.start, opened.end, opened.channels, opened.notes, opened.dropped]
    said += [repr(message.message) for message in opened.messages(*opened.channels, *opened.derived)]
    said += [opened.arrow(name).num_rows for name in opened.channels]
    unpacked = named("recording.capsule:unpack")(opened.attachments, path.with_name("unpacked"))
    return [*said, *opened.commands(), repr(unpacked)]


def map_bytes(path: Path) -> bytes:
    """Read a map."""
    return bytes(named("mapping:OccupancyMap.read")(path).to_bytes("ot"))


CLOUD, MESH = "mapping.files:read_cloud", "scenario.read.mesh_file:load_mesh"
CURRENT, OCEAN = "scenario.read.current_grid:read_current_grid", "scenario.read.ocean_file:read_ocean"
SCANS = "mapping.files.scan_graph:read_scans"
MISSION, TRACK = "missions.field:read_mission_file", "campaigns.datasets.track:read_track"
YAMLS = {
    "scenario": "scenario:load",
    "vehicle": "scenario.spec.vehicle:load_vehicle",
    "thruster": "scenario.spec.actuator:load_thruster",
    "sensors": "scenario.spec.sensor:load_sensors",
    "sonar": "scenario.spec.sonar:load_sonar",
    "modem": "scenario.spec.link:load_modem",
    "prop": lambda path: named("scenario.spec.prop:_prop")(path, SimpleNamespace(context={})),
    "sweep": "campaigns.sweeps.spec:read_sweep",
    "exercise": "exercises.exercise:load_exercise",
    "team": lambda path: named("league.team:load_team")(path.parent),
    "calibration": "scenario.read.calibration:calibrated_fields",
    "mapping": "exchange.logs.motion_log:read_mapping",
}
READERS = {
    "map": file("a.ot", map_bytes),
    "color_tree": file("a.ot", map_bytes),
    "depth_string": Reader(streams.depth_string),
    **{kind: file(f"cloud.{kind}", CLOUD, ("numpy.lib.npyio",)) for kind in ("pcd", "ply")},
    **{kind: file(f"cloud.{kind}", CLOUD, ("laspy",)) for kind in ("las", "laz")},
    "xyz": file("cloud.xyz", CLOUD, end=endless),
    "scan_graph": file("a.graph", lambda path: [scan.points_world_m for scan in named(SCANS)(path)]),
    "gsf": file("survey.gsf", raw_survey, ("GSFU",), endless),
    "kmall": file("survey.kmall", raw_survey, end=endless),
    "xtf": file("survey.xtf", "mapping.files.xtf_read:read_xtf", ("pyxtf",), endless),
    "xtf_soundings": file("survey.xtf", raw_survey, ("pyxtf",), endless),
    "stl": file("mesh.stl", MESH, ("trimesh.exchange",), _has_one_solid),
    "obj": file("mesh.obj", MESH, ("trimesh.exchange",), endless),
    "mesh_ply": file("mesh.ply", MESH, ("trimesh.exchange",)),
    "off": file("mesh.off", MESH, ("trimesh.exchange",)),
    "glb": file("mesh.glb", MESH, ("trimesh.exchange",)),
    "gltf": file("mesh.gltf", MESH, ("trimesh.exchange",), values=JSON),
    "fbx": file("mesh.fbx", MESH, end=endless),
    "dae": file("mesh.dae", MESH, end=endless),
    "asc": file("terrain.asc", raster),
    "tif": file("terrain.tif", raster),
    "bag": file("chart.bag", chart),
    "s102": file("chart.h5", chart),
    "gebco": file("chart.nc", chart),
    "soundings": file("soundings.xyz", soundings, end=endless),
    "image": file("terrain.png", image, ("PIL",)),
    "current_npz": file("current.npz", CURRENT, ("numpy.lib", "zipfile")),
    "current_csv": file("current.csv", CURRENT, ("csv",), endless),
    "cast": file("cast", water, end=endless),
    "argo": file("cast", water, ("scipy.io",), endless),
    "profile": file("profile.csv", water, ("csv",), endless),
    "ocean_csv": file("ocean", OCEAN, ("csv",), endless),
    "ocean_netcdf": file("ocean", OCEAN, ("scipy.io",), endless),
    **{kind: file(f"{kind}.yaml", read, ("ruamel",), endless, YAML_VALUES) for kind, read in YAMLS.items()},
    "thruster_csv": file("sheet.csv", "scenario.read.spec_file:read_sheet_rows", ("csv",), endless),
    "motion_csv": file("log.csv", motion_log, ("csv",), endless),
    "motion_mcap": file("log.mcap", motion_log, ("mcap", "rosbags"), endless),
    "dataflash": file("dive.BIN", real_flight, ("pymavlink.DFReader",), endless),
    "tlog": file("dive.tlog", real_flight, end=endless),
    "flight_bag": file("dive.bag", real_flight, ("rosbags",), endless),
    "flight_csv": file("dive.csv", real_flight, ("csv",), endless),
    "glider": file("dive.dbd", glider, ("json",), values=JSON),
    "map_bag": file("a.bag", map_of_bag, end=endless),
    "sdf": file("robot.sdf", partial(robot, read="sdf:read_sdf"), ("xml",)),
    "urdf": file("robot.urdf", partial(robot, read="urdf:read_urdf"), ("xml",)),
    "stonefish": file("robot.scn", partial(robot, read="stonefish:read_stonefish"), ("xml",)),
    "xacro": file("a.xacro", xacro, ("xacro", "xml")),
    "unity": file("a.unity", unity_scene, ("ruamel",), endless),
    "plan": file("mission", MISSION, ("json",), values=JSON),
    "waypoints": file("mission", MISSION, end=endless),
    "geojson": file("mission", MISSION, ("json",), values=JSON),
    "kml": file("mission", MISSION, ("xml",)),
    "kmz": file("mission.kmz", MISSION, ("xml", "zipfile")),
    "track_csv": file("track.csv", TRACK, ("csv",), endless),
    "track_npz": file("track.npz", TRACK, ("numpy.lib", "zipfile")),
    "survey_track": file("track.npz", "scoring.survey_track:SurveyTrack.read", ("numpy.lib", "zipfile")),
    "mcap": file("run.mcap", recording, ("mcap", "rosbags")),
    "result": file("result.json", result, ("json",), values=JSON),
    "json": Reader(streams.json_text, ("json",), endless, JSON),
    "moos": Reader(streams.moos, has_end=endless),
    "imc": Reader(streams.imc, has_end=endless),
    "notes": Reader(streams.notes, ("json",), values=JSON),
    "commands": Reader(streams.commands, ("pydantic", "json"), endless, JSON_LINES),
    "cdr": Reader(streams.cdr, ("rosbags",)),
    "ping": Reader(streams.ping, has_end=endless),
    "a50": Reader(streams.a50, ("json",), endless, JSON_LINES),
    "upload": Reader(streams.upload, values=JSON),
    "mesh_upload": Reader(streams.mesh_upload, has_end=endless, values=JSON_LINES),
    "frames": Reader(streams.frames, ("cbor2", "json"), endless, JSON_LINES),
}
"""The readers by the name that `tools/fuzz` takes."""
