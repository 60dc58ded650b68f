"""Raw surveys: what is written is read by others' software and grids to the same bed; real surveys are read."""

import itertools
import json
import math
import struct
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import uwsim as uwsim_command
from flown_survey import LATITUDE, LONGITUDE, POOL, Flown, grids_apart_m, traced, traced_from_travel_times
from uwsim import _core
from uwsim.channels import Table
from uwsim.cli.map_build import build
from uwsim.cli.map_convert import convert
from uwsim.flight.raw_options import RawOptions
from uwsim.flight.raw_places import PatchErrors
from uwsim.flight.survey import run_survey
from uwsim.live import LiveSimulator
from uwsim.mapping.files.gsf_read import read_gsf
from uwsim.mapping.files.swath import survey_format
from uwsim.recording import Recorder
from uwsim.recording.cli.map_from import from_recording
from uwsim.recording.reader import Recording
from uwsim.scoring.tpu import Uncertainties

REAL = Path(__file__).parents[4] / "shared" / "reality"


def test_a_flights_track_is_where_its_pings_are(bent):
    """Degrees of the track, at the times of Leidos' pings, are the pings' own to a tenth of a metre."""
    gsfpy = pytest.importorskip("gsfpy3_09", reason="needs gsfpy, which has Leidos' library")
    from gsfpy3_09.enums import RecordType

    track = np.genfromtxt(bent.folder / "out" / "track-rov.csv", delimiter=",", names=True)
    assert track["latitude_deg"][0] == pytest.approx(LATITUDE, abs=1e-4)
    with gsfpy.open_gsf(str(bent.gsf)) as file:
        for _ in range(20):
            _, record = file.read(RecordType.GSF_RECORD_SWATH_BATHYMETRY_PING)
            ping = record.mb_ping
            seconds = ping.ping_time.tv_sec + 1e-9 * ping.ping_time.tv_nsec - 1_577_836_800
            first, second = ping.latitude, ping.longitude  # gsfpy's names are in another order than those of gsf.h
            for name, degrees in (("longitude_deg", first), ("latitude_deg", second)):
                assert np.interp(seconds, track["time_s"], track[name]) == pytest.approx(degrees, abs=1e-6)


def by_leidos(path: Path, every: int) -> tuple[np.ndarray, np.ndarray, dict[int, int]]:
    """Return the file's own soundings and those traced from its travel times, as Leidos' C library reads it."""
    gsfpy = pytest.importorskip("gsfpy3_09", reason="needs gsfpy, which has Leidos' library")
    from gsfpy3_09.enums import RecordType

    curvature = math.radians(LATITUDE)
    e2 = 6.69437999014e-3
    w = 1.0 - e2 * math.sin(curvature) ** 2
    north_m, east_m = 6378137.0 * (1 - e2) / w**1.5, 6378137.0 / math.sqrt(w) * math.cos(curvature)
    stated, again, kinds = [], [], {}
    with gsfpy.open_gsf(str(path)) as file:
        while True:
            try:
                what, record = file.read()
            except Exception as error:
                assert "End of file" in str(error), error
                break
            kinds[what.recordID] = kinds.get(what.recordID, 0) + 1
            if what.recordID == RecordType.GSF_RECORD_SOUND_VELOCITY_PROFILE:
                count = record.svp.number_points
                profile = np.array(record.svp.depth[:count]), np.array(record.svp.sound_speed[:count])
            if what.recordID != RecordType.GSF_RECORD_SWATH_BATHYMETRY_PING:
                continue
            ping = record.mb_ping
            names = ("depth", "across_track", "along_track", "travel_time", "beam_angle", "beam_angle_forward")
            arrays = {name: np.array(getattr(ping, name)[: ping.number_beams]) for name in names}
            seen = np.array([flag == b"\x00" or flag == 0 for flag in ping.beam_flags[: ping.number_beams]])
            heading = math.radians(ping.heading)
            ahead = np.array([math.sin(heading), math.cos(heading)])
            beam = np.array([math.cos(heading), -math.sin(heading)])
            longitude, latitude = ping.latitude, ping.longitude  # gsfpy swaps them, in real files, too
            place = np.radians([longitude - LONGITUDE, latitude - LATITUDE]) * [east_m, north_m]
            flat = place + arrays["along_track"][:, None] * ahead + arrays["across_track"][:, None] * beam
            stated.append(np.column_stack([flat, -arrays["depth"]])[seen])
            if kinds[what.recordID] % every:
                continue
            down = np.cos(np.radians(arrays["beam_angle"]))
            ray = traced(ping.depth_corrector, down[seen], arrays["travel_time"][seen], *profile)
            azimuth = np.radians(arrays["beam_angle_forward"][seen])
            again.append((ray, azimuth, *(arrays[name][seen] for name in ("depth", "across_track", "along_track"))))
    return np.concatenate(stated), again, kinds


def test_leidos_library_reads_the_survey_and_it_grids_to_our_own_bed(bent):
    stated, again, kinds = by_leidos(bent.gsf, every=10)
    assert kinds[2] == kinds[12] == len(bent.record.path_world_m)
    apart_m = grids_apart_m(bent.own_soundings, stated)
    assert len(apart_m) > 100
    assert apart_m.max() < 0.01
    assert len(again) > 5
    for ray, azimuth, depth, across, along in again:  # from travel times, by another tracer
        assert np.abs(ray[:, 1] - depth).max() < 0.006  # the head's depth is in whole centimetres
        offsets = np.array([across - ray[:, 0] * np.cos(azimuth), along - ray[:, 0] * np.sin(azimuth)])
        assert np.ptp(offsets, axis=1).max() < 0.01  # one lever arm for all beams of a ping


def test_a_live_runs_recording_gives_the_survey_of_its_pings(straight, tmp_path):
    """Each ping of the recorder, at its time: the bed is where it is."""
    path = tmp_path / "live.mcap"
    with (
        LiveSimulator(str(straight.scenario), speed="max", paused=True) as live,
        Recorder(live, path, topics=["sonar_ping"], shared=Table(live.simulator)),
    ):
        live.rov.undock()
        live.step(50)
        live.rov.set_effort(surge=0.7, yaw=0.2)
        live.step(150)
    times_ns = [each.message.header.stamp.nanosec for each in Recording(path).messages("sonar_ping")]
    for suffix in (".gsf", ".xtf"):
        from_recording(source=path, out=tmp_path / "map.bt", written=RawOptions(tmp_path / f"live{suffix}"))
        assert (tmp_path / f"live{suffix}").stat().st_size > 1000
    swaths = list(read_gsf(tmp_path / "live.gsf")[1])
    assert len(swaths) == len(times_ns) > 10
    for swath, nanosec in zip(swaths, times_ns, strict=True):
        assert swath.time_ns % 10**9 == pytest.approx(nanosec, abs=2000)
        seen = swath.is_detected
        assert seen.any()
        assert np.ptp(swath.sounding_m[seen, 2]) < 3.0
        assert np.median(swath.sounding_m[seen, 2]) == pytest.approx(9.0, abs=1.0)


@pytest.mark.parametrize("suffix", [".bag", ".tif"])
def test_a_surveys_grid_has_the_bed_and_the_uncertainty_of_its_soundings(bent, tmp_path, suffix):
    """In the UTM zone, as GDAL reads it: the bed at 9 m, within the uncertainty that the grid states."""
    rasterio = pytest.importorskip("rasterio")
    convert(bent.gsf, tmp_path / f"grid{suffix}", cell_m=0.5)
    with rasterio.open(tmp_path / f"grid{suffix}") as file:
        layers = dict(zip(file.descriptions, file.read(masked=True).astype(float).filled(np.nan), strict=True))
        west, south, east, north = rasterio.warp.transform_bounds(file.crs, "EPSG:4326", *file.bounds)
        assert "UTM zone 32N" in file.crs.to_wkt() or "UTM zone 31N" in file.crs.to_wkt()
    assert west < LONGITUDE < east
    assert south < LATITUDE < north
    depth = np.abs(next(layers[name] for name in ("depth", "elevation") if name in layers))
    error = layers["uncertainty"]
    seen = np.isfinite(depth) & np.isfinite(error)
    assert seen.sum() > 200
    assert np.median(depth[seen]) == pytest.approx(9.0, abs=0.02)
    stated = np.concatenate([swath.vertical_deviation_m[swath.is_detected] for swath in read_gsf(bent.gsf)[1]])
    assert np.min(error[seen]) >= 1.96 * np.nanmin(stated) - 1e-6
    assert np.mean(np.abs(depth[seen] - 9.0) <= error[seen]) > 0.95


def test_a_survey_becomes_a_cloud_but_no_map_by_conversion(bent, tmp_path):
    convert(bent.gsf, tmp_path / "cloud.xyz")
    cloud = np.loadtxt(tmp_path / "cloud.xyz")
    assert (np.abs(np.median(cloud, axis=0) - [LONGITUDE, LATITUDE, -9.0]) < [1e-4, 1e-4, 0.02]).all()
    with pytest.raises(ValueError, match="a survey file becomes a map by `uwsim map build"):
        convert(bent.gsf, tmp_path / "map.bt")
    with pytest.raises(ValueError, match=r"cell: missing: points have no voxels"):
        convert(bent.gsf, tmp_path / "grid.tif")


def test_a_run_whose_time_was_reset_gives_no_raw_survey(straight, tmp_path):
    with (
        LiveSimulator(str(straight.scenario), speed="max", paused=True) as live,
        Recorder(live, tmp_path / "live.mcap", topics=["sonar_ping"], shared=Table(live.simulator)),
    ):
        live.step(50)
        live.reset()
        live.step(50)
    with pytest.raises(ValueError, match=r"live\.mcap': tick \d+: its time was reset, at which a raw survey ends"):
        written = RawOptions(tmp_path / "live.gsf")
        from_recording(source=tmp_path / "live.mcap", out=tmp_path / "map.bt", written=written)
    assert not (tmp_path / "live.gsf").exists()


def test_errors_of_installation_are_found_back(straight):
    errors = {"roll": {"roll": 0.8}, "pitch": {"pitch": -0.6}, "heading": {"heading": 2.0}, "late": {"latency": 0.3}}
    asked = tuple({"errors": PatchErrors(**each)} for each in errors.values())
    paths = straight.raws_of_recording(*(f"{name}.gsf" for name in errors), asked=asked)
    found = {name: list(read_gsf(path)[1]) for name, path in zip(errors, paths, strict=True)}
    true = list(read_gsf(straight.gsf)[1])
    k = len(true) // 2  # under way; the bed is level, 9 m deep
    seen = true[k].is_detected & (np.abs(true[k].sounding_m[:, 1]) < 3.0)
    along, across, depth = true[k].sounding_m[seen].T
    below_m = np.median(depth) - (true[k].reference_depth_m + true[k].transducer_m[2])
    # The survey assumes a head with less roll to starboard, so that it takes the starboard side for shallower.
    slope = np.polyfit(across, found["roll"][k].sounding_m[seen, 2] - depth, 1)[0]
    assert math.degrees(math.atan(slope)) == pytest.approx(-0.8, abs=0.05)
    moved = np.median(found["pitch"][k].sounding_m[seen, 0] - along)
    assert math.degrees(math.atan(moved / below_m)) == pytest.approx(0.6, abs=0.05)
    turn = np.polyfit(across, found["heading"][k].sounding_m[seen, 0] - along, 1)[0]
    assert math.degrees(math.atan(turn)) == pytest.approx(2.0, abs=0.1)
    times_ns, latitudes_deg, headings_rad = np.array([(p.time_ns, p.latitude_deg, p.heading_rad) for p in true]).T
    before_deg = np.interp(times_ns - 3e8, times_ns, latitudes_deg)
    late_deg, late_rad = np.array([(ping.latitude_deg, ping.heading_rad) for ping in found["late"]]).T
    assert 111_111.0 * (late_deg - before_deg)[20:] == pytest.approx(0.0, abs=0.03)
    assert late_rad[20:] == pytest.approx(headings_rad[20:], abs=2e-4)


def test_truth_and_tpu_are_side_by_side(bent, tmp_path):
    """Ranges in physics mode err as the sounder states; an unknown roll is seen by the truth alone."""
    assert bent.record.soundings.by_tpu.name == bent.record.soundings.by_truth.name == "Exclusive"
    assert bent.record.soundings.within_own == pytest.approx(0.95, abs=0.01)
    known = Uncertainties(roll=0.1, depth=0.03, position=0.6)
    options = {"offsets": PatchErrors(roll=10.0), "uncertainty": known, "report": "json"}
    flown = Flown(tmp_path, "a.gsf", ", mode: physics", **options)
    assert flown.record.soundings.by_tpu.name == "Special"  # 2.45 x 0.6 m is more than 1 m
    assert flown.record.soundings.within_own < 0.3
    values = json.loads((tmp_path / "out" / "summary.json").read_text())["soundings"]
    assert values["s44_order_by_tpu"] == "Special"
    assert values["s44_order_by_truth"] != "Exclusive"
    asked = {"offsets": "roll=10", "uncertainty": "roll=0.1,depth=0.03,position=0.6"}
    written = RawOptions(tmp_path / "again.gsf", **asked)
    from_recording(source=flown.recording, out=tmp_path / "map.bt", written=written)
    live, again = (list(read_gsf(path)[1]) for path in (flown.raw, tmp_path / "again.gsf"))
    swath = live[5]
    middle = swath.is_detected & (np.abs(swath.beam_rad) < 0.01)
    assert swath.vertical_deviation_m[middle] == pytest.approx(0.03, abs=0.003)
    assert (swath.horizontal_deviation_m[swath.is_detected] >= 0.6).all()
    assert len(live) == len(again) > 50
    for mine, other in zip(live, again, strict=True):
        for name in ("vertical_deviation_m", "horizontal_deviation_m", "sounding_m"):
            np.testing.assert_allclose(getattr(other, name), getattr(mine, name), atol=3e-4)


def test_a_mission_s_file_has_errors_of_installation_too(tmp_path):
    (tmp_path / "scenario.yaml").write_text(POOL.replace("SONAR", ""))
    (tmp_path / "mission.py").write_text(
        "from uwsim.missions import wait\n\n\ndef mission(vehicle):\n    yield wait(0.5)\n"
    )
    asked = ("run", "mission.py", "--scenario", "scenario.yaml", "--out", "out", "--report", "none")
    asked = (*asked, "--offsets", "roll=0.5")
    flown = uwsim_command(*asked, "--map", "--raw", "a.gsf", cwd=tmp_path)
    assert flown.returncode == 0, flown.stderr
    assert b"errors of installation: roll 0.5 deg" in (tmp_path / "a.gsf").read_bytes()
    refused = uwsim_command(*asked, cwd=tmp_path)
    assert refused.returncode == 2
    assert "--raw" in refused.stderr


@pytest.mark.parametrize("text", ["roll", "yaw=1", "roll=1,roll=2", "roll=nan", "latency=-1", "pitch=11", ""])
def test_wrong_errors_of_installation_are_refused(text):
    with pytest.raises(ValueError, match="--offsets"):
        PatchErrors.parse(text)


def test_a_map_from_the_file_has_the_voxels_of_the_flight(bent, tmp_path):
    build(tmp_path / "map.bt", [bent.gsf], voxel=0.25, origin=(LATITUDE, LONGITUDE))
    bed = uwsim.OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()[:, 2]
    assert np.median(bed) == pytest.approx(-9.0, abs=0.3)


def test_straight_rays_have_one_speed_and_round_trip(straight):
    head, swaths = read_gsf(straight.gsf)
    assert np.ptp(head.profile.speeds_m_s) == 0
    profile = _core.SoundSpeedProfile(head.profile.depths_m, head.profile.speeds_m_s)
    for swath in list(swaths)[::20]:
        ends = traced_from_travel_times(swath, profile)
        np.testing.assert_allclose(ends, swath.sounding_m[swath.is_detected], atol=0.006)


@pytest.mark.parametrize(("name", "share"), [
    ("0059_20181102_212138_EX1811_MB_EM302.gsf", 0.0025), ("0029_20160323_185603_EX1604_EM302.gsf", 0.002),
])  # fmt: skip
def test_a_real_survey_is_met_by_its_own_travel_times(name, share):
    path = REAL / "gsf" / name
    if not path.exists():
        pytest.skip("the real survey is not here: it is not ours to keep")
    head, swaths = read_gsf(path)
    profile, misfits, depths = _core.SoundSpeedProfile(head.profile.depths_m, head.profile.speeds_m_s), [], []
    for swath in itertools.islice(swaths, 200):
        depth_m = swath.sounding_m[swath.is_detected, 2]
        misfits.append(traced_from_travel_times(swath, profile)[:, 2] - depth_m)
        depths.append(depth_m)
    misfit, depth = np.concatenate(misfits), np.median(np.concatenate(depths))
    assert abs(np.median(misfit)) < 0.001 * depth
    assert 1.4826 * np.median(np.abs(misfit - np.median(misfit))) < share * depth


def test_a_scenario_without_a_place_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(ValueError, match=r"--raw .*: has no place on Earth: add earth"):
        run_survey("pool", tmp_path / "out", raw=tmp_path / "a.gsf")
    assert not (tmp_path / "a.gsf").exists()
    with pytest.raises(ValueError, match=r"--raw .*a\.kmall: this format is only read"):
        run_survey("pool", tmp_path / "out", raw=tmp_path / "a.kmall")
    with pytest.raises(ValueError, match=r"must end in \.gsf"):
        survey_format(tmp_path / "a.txt", "--raw")


@pytest.mark.parametrize("cut", [0, 5, 19, 30, 700, 2000])
def test_a_truncated_file_is_refused_with_its_offset(bent, tmp_path, cut):
    path = tmp_path / "cut.gsf"
    path.write_bytes(bent.gsf.read_bytes()[:cut])
    with pytest.raises(ValueError, match=r"cut\.gsf': at byte \d+: "):
        list(read_gsf(path)[1])


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "other.gsf"
    path.write_bytes(struct.pack(">II", 4, 1) + b"\x7fELF" * 100)
    with pytest.raises(ValueError, match=r"other\.gsf': at byte 0: not a GSF record: must begin"):
        read_gsf(path)


def test_a_map_that_cannot_be_written_is_refused_before_the_survey_is_read(tmp_path):
    (tmp_path / "loop.bt").symlink_to("loop.bt")
    for name, rule in (("loop.bt", "loop of symbolic links"), ("map.txt", "must end in"), ("no/map.bt", "no folder")):
        with pytest.raises((OSError, ValueError), match=rule):
            build(tmp_path / name, [tmp_path / "absent.gsf"])
