"""Inputs that fuzzers start with: small whole files, most of them written by our own writers."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from tests.fuzz import charts, fields, others
from tests.fuzz.readers import CDR_TYPES, simulator_to_restore
from tests.fuzz.surveys import side_scan, survey, xtf_soundings
from tests.python.fbx_file import write_blender_fbx
from tests.python.flight_logs import Flown, dataflash, telemetry

ASC = b"ncols 4\nnrows 3\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n" + b"-1 -2 -3 -4\n" * 3
CSV = b"x_m,y_m,z_m,u_m_s,v_m_s,w_m_s\n0,0,-9,0.1,0,0\n5,0,-9,0.2,0,0\n0,5,-9,0.1,0,0\n5,5,-9,0.3,0,0\n"
DAE = b"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
PLAN = b"""{"fileType": "Plan", "version": 1, "mission": {"plannedHomePosition": [54.4, 10.2, 0], "items": [
{"type": "SimpleItem", "command": 16, "frame": 3, "doJumpId": 1, "params": [0, 0, 0, null, 54.4, 10.2, -2]},
{"type": "ComplexItem", "complexItemType": "survey", "angle": 30, "polygon": [[54.4, 10.2], [54.5, 10.2], [54.5, 10.3]],
"TransectStyleComplexItem": {"CameraCalc": {"DistanceToSurface": 5, "DistanceMode": 1, "AdjustedFootprintSide": 4},
"VisualTransectPoints": [[54.4, 10.2], [54.5, 10.2]]}},
{"type": "ComplexItem", "complexItemType": "CorridorScan", "CorridorWidth": 9, "EntryPoint": 1, "polyline":
[[54.4, 10.2], [54.5, 10.2], [54.5, 10.3]], "TransectStyleComplexItem": {"TurnAroundDistance": 2, "CameraCalc":
{"DistanceToSurface": 5, "AdjustedFootprintSide": 4}}},
{"type": "SimpleItem", "command": 177, "frame": 2, "params": [1, 2, 0, 0, 0, 0, 0]}]},
"geoFence": {"circles": [{"circle": {"center": [54.4, 10.2], "radius": 50}, "inclusion": true}],
"polygons": [{"inclusion": false, "polygon": [[54.4, 10.2], [54.5, 10.2], [54.5, 10.3]]}], "version": 2},
"rallyPoints": {"points": []}}"""
WPL = b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t54.4\t10.2\t0\t1\n1\t0\t3\t16\t0\t0\t0\t0\t54.5\t10.2\t-2\t1\n"
GEOJSON = b"""{"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"heading": 30, "depth_m": 2},
"geometry": {"type": "Polygon", "coordinates": [[[10.2, 54.4], [10.3, 54.4], [10.3, 54.5], [10.2, 54.4]]]}},
{"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[10.2, 54.4, -2], [10.3, 54.4]]}}]}"""
KML = b"""<?xml version="1.0"?><kml><Document><Placemark><name>a</name><LineString><altitudeMode>absolute</altitudeMode>
<coordinates>10.2,54.4,-2 10.3,54.4,-3</coordinates></LineString></Placemark><Placemark><Polygon><outerBoundaryIs>
<LinearRing><coordinates>10.2,54.4 10.3,54.4 10.3,54.5 10.2,54.4</coordinates></LinearRing></outerBoundaryIs></Polygon>
</Placemark></Document></kml>"""
ROBOTS = Path(__file__).parents[1] / "python" / "data" / "robots"
PROFILE = b"# a cast\ndepth_m,temperature_deg_c,salinity_psu\n0,18,0\n5,12.5,0.1\n20,6,0.2\n"
SHEET = (
    b"# ours\nvoltage_v,command,thrust_n,current_a,rpm\n10,-1,-5,1,900\n10,1,5,1,900\n16,-1,-9,2,1200\n16,1,9,2,1200\n"
)
MAPPING = b"""time_s: t
position_m: [x, y, z]
orientation_xyzw: [a, b, c, d]
effort: [e, null, null, null, null, null]
noise: {position: 0.02, attitude: 5e-3}
"""
SWEEP = b"""description: two speeds
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
TRACK = b"time_s,x_m,y_m,z_m,yaw_rad,pitch_rad,roll_rad\n0,1,2,-3,0.1,0,0\n0.5,1.5,2,-3,0.2,0,0.01\n"
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


def seeds(name: str) -> dict[str, bytes]:
    """Return the inputs that a reader's fuzzer starts with, by file name."""
    made = _MAKERS[name]()
    return {f"{name}-{number}": data for number, data in enumerate(made)}


def _points() -> np.ndarray:
    return np.array([[0.1, 0.2, -3.0], [1.5, -2.25, -3.5], [40.0, 1e-3, -4.0]], np.float32)


def _cloud(suffix: str) -> Callable[[], list[bytes]]:
    def make() -> list[bytes]:
        from uwsim.mapping.files import write_cloud

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"cloud{suffix}"
            write_cloud(path, _points())
            data = Path(__file__).parents[1] / "python" / "data"
            return [path.read_bytes(), *(each.read_bytes() for each in sorted(data.glob(f"*{suffix}")))]

    return make


def _scan_graph() -> list[bytes]:
    """Two scans of OctoMap, and the edge between them."""
    from uwsim.mapping.files.scan_graph import POINT, POSE

    points, pose = np.zeros(3, POINT), np.zeros(1, POSE)
    points["count"], points["xyz"] = 3, np.arange(9.0).reshape(3, 3)
    pose["three"], pose["four"], pose["uxyz"] = 3, 4, (1.0, 0.0, 0.0, 0.0)
    node = np.uint32(3).tobytes() + points.tobytes() + pose.tobytes()
    edge = np.zeros(2, np.uint32).tobytes() + pose.tobytes()[:-4] + np.float64(1.0).tobytes()
    return [np.uint32(2).tobytes() + 2 * node + np.uint32(1).tobytes() + edge]


def _mesh(suffix: str) -> Callable[[], list[bytes]]:
    def make() -> list[bytes]:
        import trimesh

        box = trimesh.creation.box((1, 2, 3))
        if suffix == "gltf":  # in one file, with its buffers in base64
            return [trimesh.exchange.gltf.export_gltf(trimesh.Scene(box), embed_buffers=True)["model.gltf"]]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"box.{suffix}"
            trimesh.Scene(box).export(path) if suffix == "glb" else box.export(path)
            made = [path.read_bytes()]
        if suffix == "stl":
            made.append(box.export(file_type="stl_ascii").encode())
        if suffix == "ply":
            made.append(box.export(file_type="ply", encoding="ascii"))
        return made

    return make


def _fbx() -> list[bytes]:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.fbx"
        return [write_blender_fbx(path, "part", corners.astype(float), np.array(quads, np.int32)).read_bytes()]


def _map() -> list[bytes]:
    from uwsim.mapping import OccupancyMap

    occupancy = OccupancyMap(resolution_m=0.5)
    occupancy.insert_scan(_points(), (0.0, 0.0, 0.0))
    return [occupancy.to_bytes("bt"), occupancy.to_bytes("ot")]


def _state() -> list[bytes]:
    """Return nothing: the native fuzzer mutates states that it saves itself."""
    return [b""]


def _depth_string() -> list[bytes]:
    return [b"\x0312.31a12.3a55a", b"\x021E-05a0a", b"\x011.234568E+07a"]


def _tif() -> list[bytes]:
    from rasterio.io import MemoryFile
    from rasterio.transform import from_origin

    heights = -np.arange(12, dtype=np.float32).reshape(1, 3, 4)
    made = []
    for crs, more in (("EPSG:32616", {}), (None, {"compress": "deflate"}), (None, {"tiled": True, "compress": "lzw"})):
        with MemoryFile() as memory:
            size: dict[str, Any] = {"height": 3, "width": 4, "count": 1, "dtype": "float32"}
            place = from_origin(1000, 2000, 5, 5)
            with memory.open(driver="GTiff", crs=crs, transform=place, **size, **more) as file:
                file.write(heights)
            made.append(bytes(memory.read()))
    return made


def _image() -> list[bytes]:
    from PIL import Image

    grey, made = np.arange(48, dtype=np.uint8).reshape(6, 8), []
    for array, kind in ((grey, "PNG"), (grey.astype(np.uint16) * 257, "PNG"), (grey, "TIFF"), (grey, "BMP")):
        file = io.BytesIO()
        Image.fromarray(array).save(file, kind)
        made.append(file.getvalue())
    return made


def _npz() -> list[bytes]:
    made = []
    for save in (np.savez, np.savez_compressed):
        file = io.BytesIO()
        axis = np.array([0.0, 5.0])
        save(file, x_m=axis, y_m=axis, z_m=axis - 9, velocity_m_s=np.zeros((2, 2, 2, 3)))
        made.append(file.getvalue())
    return made


def _scenarios() -> list[bytes]:
    from uwsim.scenario.read.assets import assets_folder

    return [path.read_bytes() for path in sorted((assets_folder() / "scenarios").glob("*.yaml"))]


def _parts(folder: str) -> Callable[[], list[bytes]]:
    def make() -> list[bytes]:
        from uwsim.scenario.read.assets import assets_folder

        return [path.read_bytes() for path in sorted((assets_folder() / folder).glob("*.yaml"))]

    return make


def _track_npz() -> list[bytes]:
    made = []
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))
    for save in (np.savez, np.savez_compressed):
        file = io.BytesIO()
        save(file, time_s=np.arange(3.0), position_world_m=_points().astype(np.float64), orientation_xyzw=turns)
        made.append(file.getvalue())
    return [*made, *_survey_track()]


def _survey_track() -> list[bytes]:
    from uwsim.scoring.survey_track import SurveyTrack

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "track.npz"
        SurveyTrack(_points().astype(np.float64), np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]]), 50.0, "lake").write(
            path
        )
        return [path.read_bytes()]


def _notes() -> list[bytes]:
    from uwsim import _core
    from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint

    sim, saved = simulator_to_restore()
    return [_core.saved_notes(saved, scenario_fingerprint(sim.scenario), build_fingerprint()).encode()]


def _motion_log() -> list[bytes]:
    rows = [f"{0.1 * k:.1f},{0.02 * k:.2f},0,-9,0,0,0,1,{0.3 if k < 12 else -0.2}" for k in range(30)]
    return ["\n".join(["t,x,y,z,a,b,c,d,e", *rows, ""]).encode()]


def _glider() -> list[bytes]:
    quantities = ("roll", "pitch", "heading", "depth", "lat", "lon", "ballast_pumped", "battpos")
    names = [f"m_{each}" for each in quantities]
    times_s = [4.0 * k for k in range(12)]
    return [json.dumps({name: [times_s, [0.01 * k * j for j in range(12)]] for k, name in enumerate(names)}).encode()]


def _kmz(method: int) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        archive.writestr("doc.kml", KML)
        archive.writestr("images/a.png", b"")
    return file.getvalue()


def _flight() -> Flown:
    """Return a flight of 25 rows, of no model."""
    k = np.arange(25.0)
    still, turns = np.zeros((25, 6)), np.tile([0.0, 0.0, 0.0, 1.0], (25, 1))
    return Flown(0.1 * k, np.outer(k, [0.1, 0.1, -1.0]), turns, still, np.tile(1500 + 10 * k[:, None].astype(int), 8))


def _bag(topic: str, name: str, fields: Callable[[Any, int], dict[str, Any]]) -> list[bytes]:
    """A bag of ROS 1 with 25 messages. fields: from the types by name, and a message's number."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with tempfile.TemporaryDirectory() as folder:
        with Writer(path := Path(folder) / "dive.bag") as writer:
            connection = writer.add_connection(topic, name, typestore=store)
            for k in range(25):
                message = store.types[name](**fields(store.types, k))
                writer.write(connection, 10**8 * (k + 1), store.serialize_ros1(message, name))
        return [path.read_bytes()]


def _commanded(t: Any, k: int) -> dict[str, Any]:
    return {"layout": t["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0), "data": np.full(8, 0.01 * k)}


def _scanned(t: Any, k: int) -> dict[str, Any]:
    stamp = t["builtin_interfaces/msg/Time"](sec=k, nanosec=0)
    numbers = ("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max")
    found: dict[str, Any] = dict(zip(numbers, (-0.5, 0.4, 0.01, 0.0, 0.0, 0.1, 30.0), strict=True))
    header = t["std_msgs/msg/Header"](seq=k, stamp=stamp, frame_id="sonar")
    return found | {"header": header, "ranges": np.full(91, 4.05, np.float32), "intensities": np.zeros(0, np.float32)}


def _flight_table() -> list[bytes]:
    rows = [f"{0.1 * k:.1f},{10 * k},{0.1 * k:.1f},{1500 + 10 * k},1400" for k in range(25)]
    return ["\n".join(["t,h,d,a,b", *rows, ""]).encode()]


def _motion_recording() -> list[bytes]:
    from uwsim import Simulator
    from uwsim.recording import Recorder

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        sim = Simulator("pool", seed=3)
        with Recorder(sim, path, topics=("odom", "telemetry")):
            sim.rov.release()
            sim.rov.set_effort(surge=0.3)
            sim.advance(3.0)
        return [path.read_bytes()]


def _commands() -> list[bytes]:
    return [b"\n".join(json.dumps({"tick": 0, "name": n, "arguments": a}).encode() for n, a in COMMANDS.items())]


def _recordings() -> list[bytes]:
    """Return one as it is written, and one without compression or checksums, so that mutations reach its content."""
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    from uwsim import Simulator
    from uwsim.recording import Recorder

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        sim = Simulator("pool", seed=3)
        with Recorder(sim, path, topics=("odom", "imu", "depth")):
            sim.rov.undock()
            sim.advance(0.1)
        data = path.read_bytes()
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
    from uwsim.channels.ros.cdr import encode
    from uwsim.channels.ros.messages import default_message

    return [bytes([number]) + bytes(encode(default_message(name))) for number, name in enumerate(CDR_TYPES)]


def _frames() -> list[bytes]:
    import cbor2

    text = b"\n".join(json.dumps(frame).encode() for frame in FRAMES)
    return [text, b"\n".join(b"#" + cbor2.dumps(frame).hex().encode() for frame in FRAMES)]


_MAKERS: dict[str, Callable[[], list[bytes]]] = {
    **{suffix[1:]: _cloud(suffix) for suffix in (".pcd", ".ply", ".las", ".laz", ".xyz")},
    **{suffix: _mesh(suffix) for suffix in ("stl", "obj", "off", "glb", "gltf")},
    "mesh_ply": _mesh("ply"),
    "map": _map,
    "gsf": lambda: [survey(".gsf")],
    "kmall": lambda: [survey(".kmall")],
    "xtf": lambda: [side_scan()],
    "xtf_soundings": lambda: [xtf_soundings(), xtf_soundings(61)],
    "state": _state,
    "depth_string": _depth_string,
    "fbx": _fbx,
    "dae": lambda: [DAE],
    "asc": lambda: [ASC],
    "tif": _tif,
    "bag": charts.made(".bag"),
    "s102": charts.surface,
    "scan_graph": _scan_graph,
    "gebco": charts.elevations,
    "soundings": charts.sounded,
    "image": _image,
    "current_npz": _npz,
    "current_csv": lambda: [CSV],
    "cast": fields.casts,
    "argo": fields.argo,
    "ocean_csv": fields.ocean_csv,
    "ocean_netcdf": fields.ocean_netcdf,
    "scenario": _scenarios,
    **{kind: _parts(f"{kind.removesuffix('s')}s") for kind in ("vehicle", "thruster", "sensors", "sonar", "modem")},
    "sweep": lambda: [SWEEP],
    "exercise": _parts("exercises"),
    "json": lambda: [b'{"points_m": [[1, 2.5, -3e2]], "speed": NaN}', b'[1, [true, null], "x"]\n'],
    "mapping": lambda: [MAPPING],
    "motion_csv": _motion_log,
    "motion_mcap": _motion_recording,
    "dataflash": lambda: [dataflash(_flight())],
    "tlog": lambda: [telemetry(_flight())],
    "flight_bag": lambda: _bag("/thrusters", "std_msgs/msg/Float64MultiArray", _commanded),
    "glider": _glider,
    "flight_csv": _flight_table,
    "sdf": lambda: [(ROBOTS / "glider.sdf").read_bytes()],
    "urdf": lambda: [(ROBOTS / "sled.urdf").read_bytes()],
    "stonefish": lambda: [(ROBOTS / "robot.scn").read_bytes()],
    "plan": lambda: [PLAN],
    "waypoints": lambda: [WPL],
    "geojson": lambda: [GEOJSON],
    "kml": lambda: [KML],
    "kmz": lambda: [_kmz(zipfile.ZIP_STORED), _kmz(zipfile.ZIP_DEFLATED)],
    "moos": others.moos,
    "imc": others.imc,
    "thruster_csv": lambda: [SHEET],
    "profile": lambda: [PROFILE],
    "track_csv": lambda: [TRACK],
    "track_npz": _track_npz,
    "survey_track": _survey_track,
    "notes": _notes,
    "commands": _commands,
    "mcap": _recordings,
    "cdr": _cdr,
    "prop": _parts("props"),
    "team": lambda: [others.TEAM],
    "calibration": lambda: [others.CAMERA],
    "result": lambda: [json.dumps(others.RESULT).encode()],
    "unity": lambda: [others.SCENE],
    "xacro": lambda: [others.XACRO],
    "map_bag": lambda: _bag("/scan", "sensor_msgs/msg/LaserScan", _scanned),
    "color_tree": lambda: [others.colored(_map()[1]), _map()[1]],
    "ping": lambda: [others.pings()],
    "a50": lambda: [b'{"command": "set_config", "parameters": {"speed_of_sound": 1480}}\n{"command": "trigger_ping"}'],
    "upload": lambda: [json.dumps(others.UPLOAD).encode()],
    "mesh_upload": lambda: [others.parts(_mesh("stl")()[0])],
    "frames": _frames,
}
