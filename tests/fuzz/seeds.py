"""Inputs that fuzzers start with: small whole files, most of them from the writers of the tests and our own."""

from __future__ import annotations

import base64
import io
import json
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from tests.fuzz.streams import CDR_TYPES, named, simulator_to_restore
from tests.fuzz.surveys import side_scan, survey, xtf_soundings

TESTS = Path(__file__).parents[1] / "python"
DATA = TESTS / "data"
XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="a"><xacro:arg name="n" default="2"/>
<xacro:property name="p" value="${2 * (1 + len([pi, 3])) if 1 == 1 else 'a'}"/><xacro:macro name="m" params="a b:=3 *c">
<link name="${a}_${str(p)[0:1]}_${max(b, 1)}"><xacro:insert_block name="c"/></link></xacro:macro>
<xacro:m a="$(arg n)"><b/></xacro:m><xacro:if value="$(eval n == 2)"><c/></xacro:if></robot>"""
UPLOAD = [[0, 4], [0, 16, 0, 0, 0, 0, 0, 0, 0], [3, 16, 0, 0, 0, 0, 0, 0, -2], [3, 18, 1, 0, 2, 0, 9, 9, -2],
          [2, 178, 1, 0.5, 0, 0, 0, 0, 0], [1, 1], [0, 5003, 9, 1, 0, 0, 0, 0, 0]]  # fmt: skip
SWEEP = """description: two speeds
scenario: cove
method: sobol
samples: 64
seeds: {first: 1}
vary:
  rov.drag.linear.surge: {low: 30, high: 60}
  water.current_world_m_s: {choices: {slack: [0, 0, 0], flood: [0.2, 0, 0]}}
objective: {metric: coverage, best: high}
show: [coverage, simulated_s]
require: {collisions: {high: 0}}
worst: 3
"""
COMMANDS: dict[str, dict[str, Any]] = {
    "override_failsafe": {"vehicle": "rov"},
    "set_effort": {"vehicle": "rov", "surge": 0.5, "yaw": -0.2},
    "set_wrench": {"vehicle": "rov", "force_body_n": [10.0, 0.0, 0.0]},
    "set_thrusters": {"vehicle": "rov", "commands": {}},
    "place": {"vehicle": "rov", "position_world_m": [0.0, 0.0, -2.0], "velocity_body": [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]},
    "aim": {"vehicle": "rov", "elevation_rad": -0.3},
    "set_lamp": {"vehicle": "rov", "lamp": "front", "on": True},
    "aim_camera": {"vehicle": "rov", "camera": "front", "pan_rad": 0.2},
    "set_optics": {"jerlov": "II", "sun_elevation_deg": 20.0},
    "set_parameter": {"name": "water.current_world_m_s", "value": [0.1, 0.0, 0.0]},
    "set_parameters": {"changes": {"rov.ballast_kg": 1.0}},
    "reset_parameters": {},
    "inject_fault": {"kind": "sensor", "sensor": "imu", "mode": "off", "for_s": 1.0, "name": "x"},
    "end_fault": {"name": "leak"},
    "link_send": {"sender": "rov", "receiver": "station", "topic": "odom", "payload": {"$bytes": "AAEC"}, "repeats": 1},
    "set_stream": {"key": "rov/front", "rate_hz": 2.0},
    "reset": {"seed": 3},
    "undock": {"vehicle": "rov"},
    "release": {"vehicle": "rov"},
    "all_stop": {"vehicle": "rov", "on": True},
}
FRAMES = (
    {"op": "advertise", "topic": "/t", "type": "std_msgs/String", "latch": True},
    {"op": "subscribe", "topic": "/t", "type": "std_msgs/String", "compression": "cbor", "queue_length": 2, "id": "a"},
    {"op": "publish", "topic": "/t", "msg": {"data": "x"}},
    {"op": "publish", "topic": "/scan", "type": "sensor_msgs/LaserScan", "msg": {"ranges": [1.0, 2.5]}},
    {"op": "call_service", "service": "/rosapi/topics", "args": {}, "id": "b"},
    {"op": "advertise_service", "service": "/s", "type": "std_srvs/Trigger"},
    {"op": "service_response", "service": "/s", "id": "service_request:s:1", "values": {}, "result": True},
    {"op": "fragment", "id": "c", "data": '{"op":', "num": 0, "total": 2},
    {"op": "set_level", "level": "info"},
    {"op": "unsubscribe", "topic": "/t"},
)
PROFILE = "# a cast\ndepth_m,temperature_deg_c,salinity_psu\n0,18,0\n5,12.5,0.1\n20,6,0.2\n"
SHEET = "# ours\nvoltage_v,command,thrust_n,current_a,rpm\n10,-1,-5,1,9\n10,1,5,1,9\n16,-1,-9,2,12\n16,1,9,2,12\n"
MAPPING = (
    "time_s: t\nposition_m: [x, y, z]\norientation_xyzw: [a, b, c, d]\neffort: [e, null, null, null, null, null]\n"
)
MOTION = [f"{k / 10},{k / 50},0,-9,0,0,0,1,{0.3 if k < 12 else -0.2}" for k in range(30)]
FLIGHT = [f"{k / 10},{10 * k},{k / 10},{1500 + 10 * k},1400" for k in range(25)]
TEXTS: dict[str, list[str]] = {
    "depth_string": ["\x0312.31a12.3a55a", "\x021E-05a0a", "\x011.234568E+07a"],
    "profile": [PROFILE],
    "thruster_csv": [SHEET],
    "mapping": [f"{MAPPING}noise: {{position: 0.02, attitude: 5e-3}}\n"],
    "sweep": [SWEEP],
    "motion_csv": ["\n".join(["t,x,y,z,a,b,c,d,e", *MOTION, ""])],
    "flight_csv": ["\n".join(["t,h,d,a,b", *FLIGHT, ""])],
    "track_csv": ["time_s,x_m,y_m,z_m,yaw_rad,pitch_rad,roll_rad\n0,1,2,-3,0.1,0,0\n0.5,1.5,2,-3,0.2,0,0.01\n"],
    "json": ['{"points_m": [[1, 2.5, -3e2]], "speed": NaN}', '[1, [true, null], "x"]\n'],
    "team": ["name: A\ncourse: reef-course\nprogram: [python3, pilot.py]\nperiod_s: 0.1\n"],
    "xacro": [XACRO],
    "a50": ['{"command": "set_config", "parameters": {"speed_of_sound": 1480}}\n{"command": "trigger_ping"}'],
    "upload": [json.dumps(UPLOAD)],
    "commands": ["\n".join(json.dumps({"tick": 0, "name": of, "arguments": given}) for of, given in COMMANDS.items())],
}
"""Inputs that are texts."""


def seeds(name: str) -> dict[str, bytes]:
    """Return the inputs that a reader's fuzzer starts with, by file name."""
    made = [text.encode() for text in TEXTS[name]] if name in TEXTS else _MAKERS[name]()
    return {f"{name}-{number}": data for number, data in enumerate(made)}


def of_tests(name: str) -> Any:
    """Return what a module of tests/python writes or holds, by its module and name."""
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    module, _, of = name.partition(":")
    return getattr(import_module(f"tests.python.{module}"), of)


def written(name: str, *writers: Callable[[Path], object]) -> list[bytes]:
    """Return what writers write into a file with this name."""
    made = []
    for write in writers:
        with tempfile.TemporaryDirectory() as folder:
            write(path := Path(folder) / name)
            made.append(path.read_bytes())
    return made


def packaged(folder: str) -> list[bytes]:
    """Return the packaged files of a folder of the assets."""
    assets = named("scenario.read.assets:assets_folder")()
    return [path.read_bytes() for path in sorted((assets / folder).glob("*.yaml"))]


def _points() -> np.ndarray:
    return np.array([[0.1, 0.2, -3.0], [1.5, -2.25, -3.5], [40.0, 1e-3, -4.0]], np.float32)


def _cloud(suffix: str) -> list[bytes]:
    write = named("mapping.files:write_cloud")
    ours = written(f"cloud.{suffix}", lambda path: write(path, _points()))
    return [*ours, *(each.read_bytes() for each in sorted(DATA.glob(f"*.{suffix}")))]


def _scan_graph() -> list[bytes]:
    """Two scans of OctoMap, and the edge between them."""
    from uwsim.mapping.files.scan_graph import POINT, POSE

    points, pose = np.zeros(3, POINT), np.zeros(1, POSE)
    points["count"], points["xyz"] = 3, np.arange(9.0).reshape(3, 3)
    pose["three"], pose["four"], pose["uxyz"] = 3, 4, (1.0, 0.0, 0.0, 0.0)
    node = np.uint32(3).tobytes() + points.tobytes() + pose.tobytes()
    edge = np.zeros(2, np.uint32).tobytes() + pose.tobytes()[:-4] + np.float64(1.0).tobytes()
    return [np.uint32(2).tobytes() + 2 * node + np.uint32(1).tobytes() + edge]


def _mesh(kind: str) -> list[bytes]:
    import trimesh

    solid, write = of_tests("scenario.test_meshes:solid")(), of_tests("scenario.test_meshes:write")
    if kind == "gltf":  # in one file, with its buffers in base64
        return [trimesh.exchange.gltf.export_gltf(trimesh.Scene(solid), embed_buffers=True)["model.gltf"]]
    made = written(f"box.{kind}", lambda path: write(path.parent, kind))
    if kind == "stl":
        made.append(solid.export(file_type="stl_ascii").encode())
    if kind == "ply":
        made.append(solid.export(file_type="ply", encoding="ascii"))
    return made


def _map() -> list[bytes]:
    occupancy = named("mapping:OccupancyMap")(resolution_m=0.5)
    occupancy.insert_scan(_points(), (0.0, 0.0, 0.0))
    return [occupancy.to_bytes("bt"), occupancy.to_bytes("ot")]


def _colored(path: Path) -> None:
    of_tests("mapping.test_other_trees:tree_of")(b"ColorOcTree", path.parent)


def _raster(suffix: str, driver: str, crs: str | None = None, cell: float = 5.0) -> list[bytes]:
    from affine import Affine

    heights, write = -20.0 - np.arange(48.0).reshape(6, 8), of_tests("exchange.test_from_chart:write")
    place = Affine(cell, 0, 5, 0, -cell, 43)
    return written(f"a.{suffix}", lambda path: write(path, heights, driver, crs, place))


def _bag_chart() -> list[bytes]:
    x, y = np.meshgrid(np.arange(8) + 0.5, np.arange(6) + 0.5)
    points = np.column_stack([x.ravel(), y.ravel(), -20.0 - x.ravel() - 0.5 * y.ravel()])[1:]  # one cell is empty
    grid = named("mapping.depth_grid:depth_grid")(points, 1.0)
    place = named("mapping.files.georeference:Georeference")(
        named("mapping.files.georeference:metres_about")((5.9, 43.1))
    )
    write = named("mapping.files.formats:GRID_FORMATS")[".bag"].write
    return written("chart.bag", lambda path: write(path, grid, place))


def _s102() -> list[bytes]:
    depths = 20.0 + np.add.outer(0.5 * np.arange(6), np.arange(8))
    depths[0, 0] = np.nan
    return [of_tests("exchange.test_from_chart:s102")(depths, 520_000.0, 5_330_000.0, 1.0)]


def _soundings() -> list[bytes]:
    text = of_tests("exchange.test_soundings:text")
    grid = np.array([(k % 4, k // 4, -20 - k) for k in range(16)], float)
    scattered = np.random.default_rng(1).uniform(0.0, 9.0, (40, 3))
    return [text(grid, " ").encode(), text(scattered, ",", "easting,northing,depth").encode()]


def _image() -> list[bytes]:
    from PIL import Image

    grey = np.arange(48, dtype=np.uint8).reshape(6, 8)
    pictures = ((grey, "PNG"), (grey.astype(np.uint16) * 257, "PNG"), (grey, "TIFF"), (grey, "BMP"))
    return written("a", *(lambda path, a=a, kind=kind: Image.fromarray(a).save(path, kind) for a, kind in pictures))


def _track_npz() -> list[bytes]:
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))
    poses = {"time_s": np.arange(3.0), "position_world_m": _points().astype(float), "orientation_xyzw": turns}
    saves = (np.savez, np.savez_compressed)
    return [*written("a.npz", *(lambda path, save=save: save(path, **poses) for save in saves)), *_survey_track()]


def _survey_track() -> list[bytes]:
    area = np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]])
    track = named("scoring.survey_track:SurveyTrack")(_points().astype(np.float64), area, 50.0, "lake")
    return written("track.npz", track.write)


def _notes() -> list[bytes]:
    from uwsim import _core
    from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint

    sim, saved = simulator_to_restore()
    return [_core.saved_notes(saved, scenario_fingerprint(sim.scenario), build_fingerprint()).encode()]


def _glider() -> list[bytes]:
    quantities = ("roll", "pitch", "heading", "depth", "lat", "lon", "ballast_pumped", "battpos")
    names = [f"m_{each}" for each in quantities]
    times_s = [4.0 * k for k in range(12)]
    return [json.dumps({name: [times_s, [0.01 * k * j for j in range(12)]] for k, name in enumerate(names)}).encode()]


def _plans() -> list[bytes]:
    """A survey, a corridor with a fence, and a route with a jump."""
    plan, fenced, simple, corridor, box, route, files = (
        of_tests(f"missions.test_field_files:{name}")
        for name in ("plan", "fenced", "simple", "corridor", "BOX", "TRANSECTS", "FILES")
    )
    lanes = fenced(corridor([(0, 0), (20, 0)], 8, 4), box, circles=[((2.0, 5.0), 1.0, False)])
    return [text.encode() for text in (lanes, files["survey.plan"], plan(*route, simple(177, 1, 2)))]


def _kmz(method: int) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        archive.writestr("doc.kml", of_tests("missions.test_field_files:KML"))
        archive.writestr("images/a.png", b"")
    return file.getvalue()


def _flight(write: str) -> list[bytes]:
    """Write a flight of 25 rows, of no model."""
    k = np.arange(25.0)
    still, turns = np.zeros((25, 6)), np.tile([0.0, 0.0, 0.0, 1.0], (25, 1))
    pulses = np.tile(1500 + 10 * k[:, None].astype(int), 8)
    flown = of_tests("flight_logs:Flown")(0.1 * k, np.outer(k, [0.1, 0.1, -1.0]), turns, still, pulses)
    return [of_tests(f"flight_logs:{write}")(flown)]


def _bag_of_commands() -> list[bytes]:
    store, write = (of_tests(f"recording.test_foreign_bag:{name}") for name in ("ROS1", "write1"))
    name = "std_msgs/msg/Float64MultiArray"
    layout = store.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    rows = [store.types[name](layout=layout, data=np.full(8, 0.01 * k)) for k in range(25)]
    return written(
        "dive.bag", lambda path: write(path, [("/thrusters", name, 0.1 * (k + 1), row) for k, row in enumerate(rows)])
    )


def _bag_of_clouds() -> list[bytes]:
    store, write, dive = (of_tests(f"recording.test_foreign_bag:{name}") for name in ("ROS1", "write1", "dive"))
    return written("dive.bag", lambda path: write(path, dive(store)))


def _recorded(topics: tuple[str, ...], seconds: float) -> bytes:
    def record(path: Path) -> None:
        sim = named("simulator.simulator:Simulator")("pool", seed=3)
        with named("recording:Recorder")(sim, path, topics=topics):
            sim.rov.undock()
            sim.rov.set_effort(surge=0.3)
            sim.advance(seconds)

    return written("run.mcap", record)[0]


def _recordings() -> list[bytes]:
    """Return one as it is written, and one without compression or checksums, so that mutations reach its content."""
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    data = _recorded(("odom", "imu", "depth"), 0.1)
    out = io.BytesIO()
    plain = Writer(out, compression=CompressionType.NONE, enable_crcs=False)
    plain.start()
    reader = make_reader(io.BytesIO(data))
    for metadata in reader.iter_metadata():
        plain.add_metadata(metadata.name, metadata.metadata)
    for attachment in reader.iter_attachments():
        plain.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None
        if channel.id not in channels:
            schemas.setdefault(schema.id, plain.register_schema(schema.name, schema.encoding, schema.data))
            number = schemas[schema.id]
            channels[channel.id] = plain.register_channel(channel.topic, "cdr", number, channel.metadata)
        plain.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
    plain.finish()
    return [data, out.getvalue()]


def _cdr() -> list[bytes]:
    encode, message = named("channels.ros.cdr:encode"), named("channels.ros.messages:default_message")
    return [bytes([number]) + bytes(encode(message(name))) for number, name in enumerate(CDR_TYPES)]


def _frames() -> list[bytes]:
    import cbor2

    text = b"\n".join(json.dumps(frame).encode() for frame in FRAMES)
    return [text, b"\n".join(b"#" + cbor2.dumps(frame).hex().encode() for frame in FRAMES)]


def _exchanged(file: str) -> list[bytes]:
    """Return what other programs have sent, all of it and message by message."""
    rows = json.loads((DATA / file).read_text())
    sent = [bytes.fromhex(row["bytes"]) for row in rows if row.get("from", "MOOSDB") == "MOOSDB"]
    return [b"".join(sent), *sent]


def _pings() -> list[bytes]:
    """Return messages to a Ping1D and a Ping360."""
    encoded = named("bridges.ping_protocol.wire:encoded")
    values = {"scan_start": 0, "scan_length": 9000, "requested_id": 1211, "id": 1, "reserved": 0}
    return [b"".join(encoded(number, values, source=1) for number in (1001, 6, 2000, 1400))]


def _parts(content: bytes) -> list[bytes]:
    """Return an upload of a mesh in two parts, one a line."""
    half, about = len(content) // 2, {"name": "a.stl", "size": len(content)}
    cut = ((0, content[:half]), (half, content[half:]))
    rows = [{**about, "at": at, "data": base64.b64encode(data).decode()} for at, data in cut]
    return ["\n".join(map(json.dumps, rows)).encode()]


def _result() -> list[bytes]:
    found = of_tests("league.test_table:result_of")("a", {1: 9.0, 2: 3.0})
    return [json.dumps({key: value for key, value in found.items() if key != "digest"}).encode()]


def _scene() -> list[bytes]:
    thing, cube = of_tests("exchange.test_unity:thing"), of_tests("exchange.test_unity:CUBE")
    return [("%YAML 1.1\n" + thing(100, "wall", cube, "1, y: 2, z: 3")).encode()]


def _texts_of(name: str) -> list[bytes]:
    """Return texts that a module of the tests holds."""
    held = of_tests(name)
    texts = [held] if isinstance(held, str | bytes) else [text for text, _ in held.values()]
    return [text if isinstance(text, bytes) else text.encode() for text in texts]


_MAKERS: dict[str, Callable[[], list[bytes]]] = {
    **{kind: partial(_cloud, kind) for kind in ("pcd", "ply", "las", "laz", "xyz")},
    **{kind: partial(_mesh, kind) for kind in ("stl", "obj", "off", "glb", "gltf")},
    "mesh_ply": lambda: _mesh("ply"),
    "fbx": lambda: [*_mesh("fbx"), (DATA / "pair.fbx").read_bytes()],
    "dae": lambda: written("a.dae", of_tests("scenario.test_meshes:write_collada")),
    "map": _map,
    "color_tree": lambda: [*written("other.ot", _colored), _map()[1]],
    "state": lambda: [b""],  # the native fuzzer mutates states that it saves itself
    "scan_graph": _scan_graph,
    "gsf": lambda: [survey(".gsf")],
    "kmall": lambda: [survey(".kmall")],
    "xtf": lambda: [side_scan()],
    "xtf_soundings": lambda: [xtf_soundings(), xtf_soundings(61)],
    "asc": lambda: _raster("asc", "AAIGrid"),
    "tif": lambda: [*_raster("tif", "GTiff"), *_raster("tif", "GTiff", "EPSG:32616")],
    "gebco": lambda: _raster("nc", "netCDF", "EPSG:4326", 1 / 240),
    "bag": _bag_chart,
    "s102": _s102,
    "soundings": _soundings,
    "image": _image,
    **{
        f"current_{kind}": lambda kind=kind: written(f"a.{kind}", of_tests("scenario.test_water:write_grid"))
        for kind in ("npz", "csv")
    },
    "cast": lambda: [*_texts_of("scenario.test_casts:FILES"), PROFILE.encode()],
    "argo": lambda: written("float", partial(of_tests("scenario.test_casts:write_argo"), temperature_flags="111")),
    "ocean_csv": lambda: written("a", lambda path: of_tests("scenario.test_ocean:write")(path, "csv")),
    "ocean_netcdf": lambda: written("a", lambda path: of_tests("scenario.test_ocean:write")(path, "classic")),
    "scenario": lambda: packaged("scenarios"),
    "exercise": lambda: packaged("exercises"),
    **{kind: partial(packaged, f"{kind}s") for kind in ("vehicle", "thruster", "sonar", "modem", "prop")},
    "sensors": lambda: packaged("sensors"),
    "calibration": lambda: _texts_of("scenario.test_calibration:ROS"),
    "motion_mcap": lambda: [_recorded(("odom", "telemetry"), 3.0)],
    "dataflash": lambda: _flight("dataflash"),
    "tlog": lambda: _flight("telemetry"),
    "flight_bag": _bag_of_commands,
    "glider": _glider,
    "map_bag": _bag_of_clouds,
    **{
        kind: lambda file=file: [(DATA / "robots" / file).read_bytes()]
        for kind, file in (("sdf", "glider.sdf"), ("urdf", "sled.urdf"), ("stonefish", "robot.scn"))
    },
    "unity": _scene,
    "plan": _plans,
    "waypoints": lambda: _texts_of("missions.test_field_files:WPL"),
    "geojson": lambda: _texts_of("missions.test_charts:AREA"),
    "kml": lambda: [*_texts_of("missions.test_field_files:KML"), *_texts_of("missions.test_charts:KML_AREA")],
    "kmz": lambda: [_kmz(zipfile.ZIP_STORED), _kmz(zipfile.ZIP_DEFLATED)],
    "track_npz": _track_npz,
    "survey_track": _survey_track,
    "result": _result,
    "moos": lambda: _exchanged("moos/exchange.json"),
    "imc": lambda: _exchanged("imc/packets.json"),
    "notes": _notes,
    "mcap": _recordings,
    "cdr": _cdr,
    "ping": _pings,
    "mesh_upload": lambda: _parts(_mesh("stl")[0]),
    "frames": _frames,
}
