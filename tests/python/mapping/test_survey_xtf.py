"""Side scan in .xtf: pyxtf reads it without a warning, and it shows the bed where the vehicle flew over it."""

import math
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.fuzz.surveys import survey

from command_line import uwsim as uwsim_command
from flown_survey import LATITUDE, LONGITUDE, POOL
from uwsim.flight.raw_options import RawOptions
from uwsim.flight.survey import run_survey
from uwsim.mapping.files.swath import format_of
from uwsim.mapping.files.xtf_read import read_xtf
from uwsim.mapping.survey_soundings import read_soundings

pyxtf = pytest.importorskip("pyxtf", reason="needs pyxtf")


@pytest.fixture(scope="module")
def file(straight):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        header, packets = pyxtf.xtf_read(str(straight.raw))
    assert set(packets) == {pyxtf.XTFHeaderType.sonar}
    return header, packets[pyxtf.XTFHeaderType.sonar]


def test_pyxtf_reads_each_ping_at_its_time_and_place(straight, file):
    header, pings = file
    assert header.NavUnits == 3
    assert header.channel_count() == 2
    assert [each.TypeOfChannel for each in header.sonar_info] == [1, 2]
    assert len(pings) == len(straight.record.path_world_m)
    assert [each.PingNumber for each in pings] == list(range(len(pings)))
    times = np.array([each.get_time() for each in pings])
    assert (np.diff(times) > np.timedelta64(0)).all()
    assert times[0] >= np.datetime64("2020-01-01")
    metres = np.array([81_401.2, 111_112.2])  # per degree of longitude and latitude at 43.1 degrees north
    ship = np.array([[each.ShipXcoordinate - LONGITUDE, each.ShipYcoordinate - LATITUDE] for each in pings]) * metres
    ahead_m = np.hypot(*(np.asarray(straight.record.path_world_m)[:, :2] - ship).T)  # the path is the multibeam's
    np.testing.assert_allclose(ahead_m, np.median(ahead_m), atol=0.02)
    assert 0.4 < np.median(ahead_m) < 0.6
    depths = np.array([each.SensorDepth for each in pings]) + np.asarray(straight.record.path_world_m)[:, 2]
    np.testing.assert_allclose(depths, 0.36 - 0.22, atol=0.05)  # by the two mounts


def test_the_first_return_is_that_of_the_bed_on_both_sides(file):
    _, pings = file
    reach_m = pings[0].ping_chan_headers[0].SlantRange
    for ping in pings[::20]:
        below_m = 9.0 - ping.SensorDepth
        assert ping.SensorPrimaryAltitude == pytest.approx(below_m, abs=0.1 * below_m)
        port, starboard = (20.0 * np.log10(side) for side in (ping.data[0][::-1], ping.data[1]))
        ranges_m = (np.arange(len(port)) + 0.5) * reach_m / len(port)
        water, bed = ranges_m < 0.8 * below_m, (ranges_m > below_m) & (ranges_m < 1.5 * below_m)
        for side in (port, starboard):
            assert side[bed].max() > side[water & (ranges_m > 0.5)].max() + 20.0


def test_a_recording_gives_the_same_bytes(straight, tmp_path):
    from uwsim.recording.cli.map_from import from_recording

    from_recording(source=straight.recording, out=tmp_path / "map.bt", written=RawOptions(tmp_path / "survey.xtf"))
    assert (tmp_path / "survey.xtf").read_bytes() == straight.raw.read_bytes()


def test_port_begins_with_its_farthest_sample(tmp_path):
    from uwsim.mapping.files.side_scan_line import SideScanHead, SideScanLine
    from uwsim.mapping.files.xtf import XtfWriter

    head = SideScanHead("rov", "side_scan", 4.5e5, 50.0, 3, 0.01, 1.0, 0.5, np.array([0.1, 0.2, 0.3]), "made")
    writer = XtfWriter(tmp_path / "line.xtf", head)
    near_to_far_db = np.array([120.0, 80.0, 40.0], np.float32)
    writer.add(SideScanLine(
        1_577_836_801_234_000_000, (43.1, 5.9), (43.1, 5.9), 2.0, math.nan, math.radians(-90.0), 0.1, -0.2, 0.5, 1500.0,
        near_to_far_db, near_to_far_db + 6.0,
    ))  # fmt: skip
    writer.close()
    header, packets = pyxtf.xtf_read(str(tmp_path / "line.xtf"))
    (ping,) = packets[pyxtf.XTFHeaderType.sonar]
    np.testing.assert_allclose(20.0 * np.log10(ping.data[0]), near_to_far_db[::-1], atol=1e-4)
    np.testing.assert_allclose(20.0 * np.log10(ping.data[1]), near_to_far_db + 6.0, atol=1e-4)
    assert ping.get_time() == np.datetime64("2020-01-01T00:00:01.230")
    assert ping.SensorHeading == pytest.approx(270.0)
    assert (header.ChanInfo[1].OffsetX, header.ChanInfo[1].OffsetY) == pytest.approx((0.2, 0.1))
    assert (tmp_path / "line.xtf").stat().st_size == 1024 + ping.NumBytesThisRecord


def test_a_vehicle_without_side_scan_is_refused_before_anything_is_written(tmp_path):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(POOL.replace("SONAR", "").replace("model: rov", "model: bluerov2_heavy"))
    with pytest.raises(ValueError, match=r"survey\.xtf: holds side scan: 'rov' must have a sonar of kind side_scan"):
        run_survey(scenario, tmp_path / "out", raw=tmp_path / "survey.xtf", report="none")
    assert not (tmp_path / "survey.xtf").exists()


def test_what_is_written_is_read(straight, file):
    head, lines = read_xtf(straight.raw)
    _, pings = file
    read = list(lines)
    assert len(read) == len(pings)
    assert head.bins == len(pings[0].data[0])
    assert head.range_max_m == pytest.approx(pings[0].ping_chan_headers[0].SlantRange)
    for line, ping in zip(read, pings, strict=True):
        np.testing.assert_allclose(10.0 ** (0.05 * line.port_db[::-1]), ping.data[0], rtol=2e-5)
        np.testing.assert_allclose(10.0 ** (0.05 * line.starboard_db), ping.data[1], rtol=2e-5)
        assert np.datetime64(line.time_ns, "ns") == ping.get_time()
        assert line.sonar_deg == (ping.SensorYcoordinate, ping.SensorXcoordinate)
        assert math.degrees(line.heading_rad) == pytest.approx(ping.SensorHeading, abs=1e-4)


def of_others(bytes_per_sample: int = 2, sample_format: int = 3, pings: int = 4) -> bytes:
    """Return a file as other software writes it, by pyxtf: dual frequency, integers, navigation between the pings."""
    header = pyxtf.XTFFileHeader()
    header.NavUnits, header.NumberOfSonarChannels = 0, 4
    for number, kind in enumerate((1, 2, 1, 2)):
        channel = header.ChanInfo[number]
        channel.TypeOfChannel, channel.SubChannelNumber = kind, number
        channel.BytesPerSample, channel.SampleFormat, channel.Frequency = bytes_per_sample, sample_format, 100.0
    parts = [header.to_bytes()]
    for number in range(pings):
        ping = pyxtf.XTFPingHeader()
        ping.HeaderType, ping.NumChansToFollow = pyxtf.XTFHeaderType.sonar.value, 4
        ping.Year, ping.Month, ping.Day, ping.Second = 2021, 5, 4, number
        kinds = {1: np.uint8, 2: np.uint16, 4: np.uint32}[bytes_per_sample]
        ping.data = [np.arange(1, 101).astype(kinds)[:: 1 if k % 2 else -1] for k in range(4)]
        ping.ping_chan_headers = []
        for k in range(4):
            channel = pyxtf.XTFPingChanHeader()
            channel.ChannelNumber, channel.NumSamples, channel.SlantRange = k, 100, 50.0 if number < 2 else 25.0
            ping.ping_chan_headers.append(channel)
        ping.NumBytesThisRecord = 256 + 4 * (64 + 100 * bytes_per_sample)
        between = pyxtf.XTFHeaderNavigation()
        between.NumBytesThisRecord = 64
        parts += [ping.to_bytes(), between.to_bytes()]
    return b"".join(parts)


@pytest.mark.parametrize(("bytes_per_sample", "sample_format"), [(1, 0), (1, 8), (2, 0), (2, 3), (4, 2)])
def test_files_of_others_are_read(tmp_path, bytes_per_sample, sample_format):
    path = tmp_path / "other.xtf"
    path.write_bytes(of_others(bytes_per_sample, sample_format))
    head, lines = read_xtf(path)
    first, _, third, _ = lines
    assert (head.bins, head.range_max_m, head.frequency_hz) == (100, 50.0, 100_000.0)
    np.testing.assert_allclose(first.port_db, 20.0 * np.log10(np.arange(1, 101)), rtol=1e-6)  # the nearest first
    np.testing.assert_allclose(first.starboard_db, first.port_db)
    np.testing.assert_allclose(third.starboard_db[:50], first.starboard_db[1::2])  # at half the range
    assert np.isnan(third.starboard_db[50:]).all()
    assert math.isnan(first.vehicle_deg[0])


@pytest.mark.parametrize("cut", [0, 500, 1023, 1024, 1030, 1100, 1300, 1500, 2500])
def test_a_truncated_file_is_refused_with_its_offset(tmp_path, cut):
    path = tmp_path / "cut.xtf"
    path.write_bytes(of_others()[:cut])
    with pytest.raises(ValueError, match=r"cut\.xtf': at byte \d+: "):
        list(read_xtf(path)[1])


@pytest.mark.parametrize(("at", "value", "rule"), [
    (0, b"\x00", "must begin with a header"), (1024, b"\x00", "must begin with 0xFACE"),
    (1034, b"\xff\xff\xff\xff", "a record of 4294967295 bytes"), (1024 + 16, b"\x40", "its time: "),
    (1024 + 4, b"\xff\xff", "ends before channel"), (1024 + 256, b"\x09\x00", "channel 9: must be below 4"),
    (1024 + 256 + 4, b"\x00\x00\xc0\x7f", "must have the same range"),
    (1024 + 256 + 42, b"\xff\xff\xff\x7f", "samples: must have"),
])  # fmt: skip
def test_damage_is_refused_with_its_offset(tmp_path, at, value, rule):
    data = bytearray(of_others())
    data[at : at + len(value)] = value
    path = tmp_path / "bad.xtf"
    path.write_bytes(bytes(data))
    with pytest.raises(ValueError, match=r"bad\.xtf': at byte \d+: .*" + rule):
        list(read_xtf(path)[1])


def test_a_waterfall_is_drawn(straight, tmp_path):
    from PIL import Image

    for extra in ((), ("--over-ground",)):
        drawn = uwsim_command("map", "waterfall", str(straight.raw), "--out", "w.png", *extra, cwd=tmp_path)
        assert drawn.returncode == 0, drawn.stderr
        picture = np.asarray(Image.open(tmp_path / "w.png").convert("L"), float)
        assert picture[200:-200, 200:-200].std() > 10.0
    other = tmp_path / "a.gsf"
    other.write_bytes(b"")
    refused = uwsim_command("map", "waterfall", "a.gsf", cwd=tmp_path)
    assert "holds no side scan" in refused.stderr
    assert refused.returncode == 1
    built = uwsim_command("map", "build", "m.bt", "--from", str(straight.raw), cwd=tmp_path)
    assert "holds no pings of a multibeam" in built.stderr


def written(path, units=3, others=()):
    """Write a file from the format's tables: a flat bed at 20 m below a sensor at 2 m, heading 90, roll 4, pitch 3 deg.

    The beams look 0, 30 and -45 deg across about a head that is mounted with 2 deg of roll. The third record is the
    same swath as processed soundings, the fourth is a vendor's.
    """
    header = pyxtf.XTFFileHeader()
    header.NavUnits, header.NumberOfBathymetryChannels = units, 1
    header.ChanInfo[0].TypeOfChannel, header.ChanInfo[0].OffsetRoll = 3, 2.0
    records = [header.to_bytes()]
    across, tilt = np.radians([0.0, 30.0, -45.0]), np.radians([0.0, 1.0, -2.0])
    aim = np.column_stack([np.sin(tilt), np.cos(tilt) * np.sin(across), np.cos(tilt) * np.cos(across)])
    turn = Rotation.from_euler("ZYX", [90.0, 3.0, 4.0], degrees=True) * Rotation.from_euler("X", 2.0, degrees=True)
    rays = turn.apply(aim)  # north, east, down
    rays *= (18.0 / rays[:, 2])[:, None]
    times = 2.0 * np.linalg.norm(rays, axis=1) / 1480.0
    beams = [pyxtf.XTFQPSMBEEntry(Id=k, TwoWayTravelTime=t, BeamAngle=a, TiltAngle=b)
             for k, (t, a, b) in enumerate(zip(times, np.degrees(across), np.degrees(tilt), strict=True))]  # fmt: skip
    soundings = [pyxtf.XTFBeamXYZA(dPosOffsetTrX=n, dPosOffsetTrY=e, fDepth=d + 2.0, dTime=t)
                 for (n, e, d), t in zip(rays, times, strict=True)]  # fmt: skip
    for number, (kind, content) in enumerate([(28, beams), (17, [*soundings, pyxtf.XTFBeamXYZA()]), *others]):
        ping = pyxtf.XTFPingHeader()
        ping.HeaderType, ping.NumChansToFollow, ping.PingNumber = kind, len(content), number
        ping.Year, ping.Month, ping.Day, ping.Second = 2024, 5, 17, number
        ping.SensorYcoordinate, ping.SensorXcoordinate, ping.SensorDepth = LATITUDE, LONGITUDE, 2.0
        ping.SoundVelocity, ping.SensorHeading, ping.SensorPitch, ping.SensorRoll = 740.0, 90.0, 3.0, 4.0
        data = b"".join(bytes(each) for each in content)
        ping.NumBytesThisRecord = len(bytes(ping)) + len(data)
        records.append(bytes(ping) + data)
    path.write_bytes(b"".join(records))
    return rays[:, [1, 0, 2]] * (1.0, 1.0, -1.0) - (0.0, 0.0, 2.0)  # east, north, up


def test_soundings_lie_where_the_formats_tables_put_them(tmp_path):
    expected = written(tmp_path / "line.xtf.mb", others=[(61, [b"vendor"] * 3), (61, [b"vendor"]), (3, [])])
    with pytest.warns(UserWarning, match=r"line\.xtf\.mb': not read: 2 of type 61 \(reson_7125\)"):
        found = read_soundings(tmp_path / "line.xtf.mb", "--from")
    np.testing.assert_allclose(found.points_m[:3], expected, atol=1e-4)
    np.testing.assert_allclose(found.points_m[3:], expected, atol=1e-4)
    _, packets = pyxtf.xtf_read(str(tmp_path / "line.xtf.mb"), [pyxtf.XTFHeaderType.bathy_xyza])
    (stated,) = packets[pyxtf.XTFHeaderType.bathy_xyza]
    np.testing.assert_allclose(-found.points_m[3:, 2], [each.fDepth for each in stated.data[:3]], atol=1e-4)


def test_a_map_and_a_cloud_are_made_of_them(tmp_path):
    written(tmp_path / "line.xtf")
    built = uwsim_command("map", "build", str(tmp_path / "m.bt"), "--from", str(tmp_path / "line.xtf"))
    assert built.returncode == 0 and "2 pings, 6 soundings" in built.stdout, built.stderr
    made = uwsim_command("map", "convert", str(tmp_path / "line.xtf"), str(tmp_path / "c.xyz"))
    assert made.returncode == 0 and "6 points" in made.stdout, made.stderr


@pytest.mark.parametrize(
    ("broken", "rule"),
    [
        ({"units": 0}, "positions must be degrees"),
        ({"others": [(17, [pyxtf.XTFBeamXYZA(fDepth=5e4)])]}, "fDepth must be within 12000 m"),
        ({"others": [(28, [pyxtf.XTFQPSMBEEntry(BeamAngle=1e9)])]}, "BeamAngle must be within 360 deg"),
    ],
)
def test_what_cannot_be_is_refused_at_its_offset(tmp_path, broken, rule):
    written(tmp_path / "line.xtf", **broken)
    with pytest.raises(ValueError, match=rf"line\.xtf': at byte \d+: .*{rule}"):
        read_soundings(tmp_path / "line.xtf", "--from")


def test_a_survey_is_known_by_its_content(straight, tmp_path):
    for suffix in (".gsf", ".kmall"):
        (tmp_path / f"line{suffix}.mb").write_bytes(survey(suffix))
        assert format_of(tmp_path / f"line{suffix}.mb") == suffix[1:]
    (tmp_path / "line.gsf.mb121").write_bytes(survey(".gsf"))
    built = uwsim_command("map", "build", str(tmp_path / "m.bt"), "--from", str(tmp_path / "line.gsf.mb121"))
    assert built.returncode == 0, built.stderr
    (tmp_path / "side.mb").write_bytes(straight.raw.read_bytes())
    drawn = uwsim_command("map", "waterfall", str(tmp_path / "side.mb"))
    assert drawn.returncode == 0, drawn.stderr
    refused = uwsim_command("map", "build", str(tmp_path / "m.bt"), "--from", str(straight.raw))
    assert refused.returncode == 1 and "holds no pings of a multibeam in records of type 17 or 28" in refused.stderr
