"""A recording as tables and arrays, its map and report from the file alone, and the first difference between two."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from command_line import uwsim
from flown import with_small_cameras
from uwsim import Simulator, recording
from uwsim.bridges.playback.feed import channels_of
from uwsim.channels import Table
from uwsim.channels.families.scans import PING_TOPICS
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.flight.raw_options import RawOptions
from uwsim.flight.request import FlightRequest
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder
from uwsim.recording.cli.diff import diff as diff_command
from uwsim.recording.cli.map_from import from_recording
from uwsim.recording.diff import diff
from uwsim.recording.flight_recorder import record_ping, survey_recorder
from uwsim.recording.replay import replay
from uwsim.recording.survey_from import live_map

SCAN = "sensor_msgs/msg/LaserScan"
TOPICS = ("odom", "scan", "points", "imu", "dvl", "tf*", "stateData", "octomap_binary", "sonar_ping")


def record(path: Path, surge: float) -> recording.Recording:
    sim = Simulator("lake", seed=3)
    with Recorder(sim, path, topics=TOPICS):
        sim.rov.undock()
        sim.rov.sonar.aim(-0.6)
        sim.advance(1.0)
        sim.rov.set_effort(surge=surge)
        sim.advance(1.0)
    return recording.open(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    record(folder / "a.mcap", 0.5)
    record(folder / "b.mcap", 0.52)
    return folder


@pytest.fixture(scope="module")
def run(folder: Path) -> recording.Recording:
    return recording.open(folder / "a.mcap")


def test_a_table_has_one_row_a_message_and_a_column_a_field(run: recording.Recording) -> None:
    odom = run.pandas("odom")
    assert len(odom) == 101 and odom.index.name == "time_s" and odom.index[-1] == 2.0
    assert (odom["header.stamp_ns"] == np.round(odom.index * 1e9)).all()
    sim = replay(run).sim
    place = odom.iloc[-1][[f"pose.pose.position.{axis}" for axis in "xyz"]]
    assert tuple(place) == tuple(sim.rov.pose.position_world_m)
    static = run.arrow("/tf_static")
    assert static.num_rows == 1 and static["transforms"][0][0].as_py()["header"]["frame_id"] == "world"
    with pytest.raises(ValueError, match="topic 'odometry': must be one of"):
        run.arrow("odometry")


def test_arrays_are_arrays_with_time_and_beam(run: recording.Recording) -> None:
    scan = run.xarray("scan")
    assert scan["ranges"].dims == ("time", "beam") and scan["ranges"].shape == (26, 513)  # one row for each ping
    assert scan["angle_rad"].values[-1] == pytest.approx(-scan["angle_rad"].values[0], abs=1e-5)
    cloud = run.xarray("points")
    assert {"x", "y", "z", "intensity"} <= set(cloud) and cloud["x"].dims == ("time", "point")
    first = next(run.messages("points")).message
    assert np.isfinite(cloud["x"].values[0]).sum() == first.width
    for topic in run.channels:  # every channel is exported as tables
        assert run.arrow(topic).num_rows == run.channels[topic].message_count
        assert run.xarray(topic).sizes["time"] == run.channels[topic].message_count


def test_pictures_are_recorded_replayed_and_read_as_arrays(tmp_path: Path) -> None:
    path, sim = tmp_path / "pictures.mcap", Simulator(with_small_cameras(), seed=3)
    table, topics = Table(sim), ["camera/front/*"]
    with LiveSimulator(sim, speed="max", paused=True) as live, Recorder(live, path, topics=topics, shared=table):
        live.rov.undock()
        live.step(40)
        (service,) = (s for s in table.services if s.name == "camera/front/set_stream")
        assert service.call(live, {"quality": 30})["success"]
        live.step(40)
    run = recording.open(path)
    rgb = run.xarray("camera/front/image_raw/compressed")["rgb"]
    assert rgb.dims == ("time", "row", "column", "channel") and rgb.sizes["channel"] == 3 and rgb.dtype == np.uint8
    assert np.isfinite(run.xarray("camera/front/depth/image_raw")["image"].values).any()
    assert replay(run).difference is None


SURVEY = """
name: small
seed: 2
terrain: {source: noise, size_m: [80, 80], spacing_m: 1, bed_depth_m: 18, hill_height_m: 2, hill_wavelength_m: 60}
station: {position_m: [-14, -5, 0]}
vehicles: [{name: rov, model: rov, start: station, sonar: {model: 2, tilt_deg: 30}}]
survey: {area_m: [[-4, -3], [4, -3], [4, 3], [-4, 3]], altitude_m: 8, line_spacing_m: 12, speed_m_s: 1.0, voxel_m: 0.4}
"""


@pytest.mark.usefixtures("blank_figures")
def test_a_survey_s_map_and_report_come_from_its_recording_and_it_replays(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(SURVEY)
    run = tmp_path / "run.mcap"
    done = uwsim(
        "survey", str(tmp_path / "small.yaml"), "--out", str(tmp_path / "out"), "--report", "json",
        "--record", str(run), "--record-topic", "odom",
    )  # fmt: skip
    assert (tmp_path / "out" / "map.bt").exists(), done.stderr
    again = uwsim("map", "from", str(run), "--out", str(tmp_path / "again.bt"), "--report", str(tmp_path / "report"))
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "again.bt").read_bytes() == (tmp_path / "out" / "map.bt").read_bytes()
    assert "pings" in (tmp_path / "report" / "report.html").read_text()
    assert OccupancyMap.read(tmp_path / "again.bt").statistics().occupied_voxels > 100
    result = replay(run)
    assert result.difference is None and result.state_compared and result.commands > 100

    film = tmp_path / "film.gif"
    done = uwsim("map", "film", str(run), "--out", str(film), "--pictures", "3", "--width", "300")
    assert done.returncode == 0, done.stderr
    with Image.open(film) as moving:
        assert moving.n_frames == 3
        halves = [np.asarray(frame.convert("L"), float)[44:] for frame in ImageSequence.Iterator(moving)]
    away = [np.abs(each[:, :300] - each[:, -300:]).mean() for each in halves]
    assert away[0] > 1.2 * away[2], away  # the map approaches the truth
    assert np.abs(halves[0] - halves[2])[:, :300].mean() < 5.0  # which does not change, but for the palette
    done = uwsim("map", "film", str(run), "--out", str(tmp_path / "film.mp4"))
    assert done.returncode != 0 and "must end in .webp or .gif" in done.stderr


def test_what_follows_from_a_survey_s_pings_is_not_recorded_but_read(tmp_path: Path) -> None:
    path, sim = tmp_path / "run.mcap", survey_simulator(tmp_path)
    request = FlightRequest(scenario="small.yaml", seed=2, map=True, voxel_m=0.4)
    table = Table(sim)
    pings = table.pings["rov"]
    live = {topic.name: topic.channel(table.sources[0], pings) for topic in PING_TOPICS}
    said: dict[str, list[bytes]] = {name: [] for name in live}
    with survey_recorder(sim, path, request, None) as recorder:
        sim.rov.undock()
        sim.rov.sonar.aim(-0.6)
        for _ in range(20):
            sim.advance(0.1)  # the head pings again, since its pings are 0.08 s apart
            taken = pings.newest(sim)
            record_ping(recorder, taken.ping, sim.rov.telemetry(), sim.rov.pose.world_from_body)
            for name, channel in live.items():
                said[name].append(bytes(encode(channel.read(sim))))
    run = recording.open(path)
    assert set(run.derived) == {*live, "map_changes"} and not set(run.derived) & set(run.channels)
    assert {info.message_count for info in run.derived.values()} == {20} and "odom" in run.channels
    for name in live:
        found = [recorded.data for recorded in run.messages("sonar_ping", name) if recorded.topic == name]
        assert len(found) == 20 and run.metadata(name)["description"]
        if name in ("points", "depthArray"):
            assert found == said[name]
        else:  # except for the ping interval, which is specific to the survey
            assert run.xarray(name).sizes["time"] == 20
    assert (run.xarray("scan")["ranges"].values == np.array([from_bytes(s, SCAN).ranges for s in said["scan"]])).all()
    assert np.unique(run.xarray("scan")["scan_time"]).tolist() == [np.float32(0.1)]
    played = {channel.name: channel for channel in channels_of(run)}
    assert played["map_changes"].delivery.latched and played["scan"].type == SCAN
    changes = [recorded.message for recorded in run.messages("map_changes")]
    occupied = sum(int(np.where(m.cells & 0x8000, 1, -1).sum()) for m in changes)
    assert occupied == live_map(run)[0].statistics().occupied_voxels > 10
    assert replay(run).difference is None
    with pytest.raises(ValueError, match=r"topic 'scam': must be one of .*scan"):
        next(run.messages("scam"))


def survey_simulator(folder: Path) -> Simulator:
    (folder / "small.yaml").write_text(SURVEY)
    return Simulator(folder / "small.yaml")


def test_a_diff_names_tick_channel_and_amount_and_draws(folder: Path, tmp_path: Path) -> None:
    a, b = recording.open(folder / "a.mcap"), recording.open(folder / "b.mcap")
    assert diff(a, a).same
    found = diff(a, b)
    assert found.partings[0].topic == "uwsim/commands" and found.partings[0].tick == 200
    odom = next(parting for parting in found.partings if parting.topic == "odom")
    assert 200 < odom.tick < 240 and odom.gaps[-1][1] > odom.gaps[0][1]
    done = uwsim("recording", "diff", str(a.path), str(b.path), "--out", str(tmp_path / "d.png"))
    assert done.returncode == 1 and done.stdout.startswith("tick 200, /uwsim/commands: ")
    assert (tmp_path / "d.png").stat().st_size > 10_000
    same = uwsim("recording", "diff", str(a.path), str(a.path))
    assert same.returncode == 0 and same.stdout.startswith("the same: ")
    as_json = uwsim("recording", "diff", str(a.path), str(b.path), "--out", str(tmp_path / "d.png"), "--json")
    values = json.loads(as_json.stdout)
    assert as_json.returncode == 1 and not values["same"] and len(values["partings"]) == len(found.partings)
    assert (values["partings"][0]["channel"], values["partings"][0]["tick"]) == ("/uwsim/commands", 200)


def test_what_only_one_recording_has_is_a_difference(folder: Path, tmp_path: Path) -> None:
    whole, fewer = recording.open(folder / "a.mcap"), tmp_path / "fewer.mcap"
    sim = Simulator("lake", seed=3)
    with Recorder(sim, fewer, topics=["odom"]):
        sim.rov.undock()
    found = diff(whole, recording.open(fewer))
    assert "odom" not in [parting.topic for parting in found.partings if "only" not in parting.text]
    assert all("only" in parting.text and "a.mcap has it" in parting.text for parting in found.partings)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.path.read_bytes()[:-20_000])
    assert diff(whole, recording.open(cut)).notes == [f"{cut}: was cut off"]


def test_mistakes_of_map_from_and_diff_are_one_line(folder: Path, tmp_path: Path) -> None:
    run = folder / "a.mcap"
    with pytest.raises(ValueError, match=r"must end in [.]bt or [.]ot"):
        from_recording(source=run, out=Path("map.png"), written=RawOptions())
    with pytest.raises(ValueError, match="no recording of a survey"):
        from_recording(source=run, out=tmp_path / "map.bt", report=tmp_path, written=RawOptions())
    with pytest.raises(ValueError, match="vehicle = 'auv'"):
        from_recording(source=run, out=tmp_path / "map.bt", vehicle="auv", written=RawOptions())
    with pytest.raises(ValueError, match=r"must end in [.]png"):
        diff_command(run, run, Path("x.jpg"))
    assert not list(tmp_path.iterdir())
