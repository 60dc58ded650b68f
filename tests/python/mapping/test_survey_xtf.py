"""Side scan in .xtf: pyxtf reads it without a warning, and it shows the bed where the vehicle flew over it."""

import math
import warnings

import numpy as np
import pytest

from flown_survey import LATITUDE, LONGITUDE, POOL, Flown
from uwsim.flight.survey import run_survey

pyxtf = pytest.importorskip("pyxtf", reason="needs pyxtf")


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    return Flown(tmp_path_factory.mktemp("xtf"), sonar="", raw="survey.xtf")


@pytest.fixture(scope="module")
def file(flown):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        header, packets = pyxtf.xtf_read(str(flown.raw))
    assert set(packets) == {pyxtf.XTFHeaderType.sonar}
    return header, packets[pyxtf.XTFHeaderType.sonar]


def test_pyxtf_reads_each_ping_at_its_time_and_place(flown, file):
    header, pings = file
    assert header.NavUnits == 3
    assert header.channel_count() == 2
    assert [each.TypeOfChannel for each in header.sonar_info] == [1, 2]
    assert len(pings) == len(flown.record.path_world_m)
    assert [each.PingNumber for each in pings] == list(range(len(pings)))
    times = np.array([each.get_time() for each in pings])
    assert (np.diff(times) > np.timedelta64(0)).all()
    assert times[0] >= np.datetime64("2020-01-01")
    metres = np.array([81_401.2, 111_112.2])  # per degree of longitude and latitude at 43.1 degrees north
    ship = np.array([[each.ShipXcoordinate - LONGITUDE, each.ShipYcoordinate - LATITUDE] for each in pings]) * metres
    ahead_m = np.hypot(*(np.asarray(flown.record.path_world_m)[:, :2] - ship).T)  # the path is the multibeam's
    np.testing.assert_allclose(ahead_m, np.median(ahead_m), atol=0.02)
    assert 0.4 < np.median(ahead_m) < 0.6
    depths = np.array([each.SensorDepth for each in pings]) + np.asarray(flown.record.path_world_m)[:, 2]
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
