"""Surveys in .kmall: small files are read as by others, their rays lead to their soundings, damage is refused."""

import math

import numpy as np
import pytest
from tests.fuzz.surveys import survey
from tests.python.mapping.kmall_file import kmall

from flown_survey import traced_from_travel_times
from uwsim import _core
from uwsim.cli.map_build import build
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files.gsf_read import read_gsf
from uwsim.mapping.files.kmall_read import _where_cones_meet, read_kmall


@pytest.fixture(params=["F", "I"])
def small(request, tmp_path):
    path = tmp_path / "small.kmall"
    path.write_bytes(kmall(request.param))
    return path


def turned(roll_deg, pitch_deg, heading_deg):
    """Return the rotation from forward, starboard, down of a body to north, east, down."""
    (cr, sr), (cp, sp), (ch, sh) = (
        (math.cos(each), math.sin(each)) for each in np.radians([roll_deg, pitch_deg, heading_deg])
    )
    return (
        np.array([[ch, -sh, 0], [sh, ch, 0], [0, 0, 1]])
        @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    )


def test_travel_times_lead_to_the_soundings(small):
    head, swaths = read_kmall(small)
    profile = _core.SoundSpeedProfile(head.profile.depths_m, head.profile.speeds_m_s)
    first, second = swaths
    assert second.time_ns - first.time_ns == 10**8
    assert (first.roll_rad, first.pitch_rad, first.heading_rad) == pytest.approx((0.01, -0.02, 1.0))
    assert (first.course_rad, first.speed_m_s) == pytest.approx((math.pi / 2, 0.5))
    level = turned(*np.degrees([0.01, -0.02]), 0.0)
    beams = np.column_stack([0.0 * first.beam_rad, -np.sin(first.beam_rad), np.cos(first.beam_rad)])
    np.testing.assert_allclose(first.axes, beams @ level.T, atol=2e-6)
    np.testing.assert_allclose(first.transducer_m, level @ [0.2, 0.0, 0.1], atol=1e-6)
    np.testing.assert_allclose(traced_from_travel_times(first, profile), first.sounding_m, atol=1e-3)
    np.testing.assert_allclose(first.sounding_m[:, 2], 12.0 + first.transducer_m[2], atol=1e-5)


@pytest.mark.parametrize("small", ["I"], indirect=True)
def test_pykmall_reads_the_same(small):
    theirs = pytest.importorskip("KMALL.kmall", reason="needs pykmall").kmall(str(small))
    theirs.index_file()
    _, (swath, _) = read_kmall(small)
    theirs.FID.seek(theirs.msgoffset[list(theirs.msgtype).index("b'#MRZ'")])
    ping = theirs.read_EMdgmMRZ()
    np.testing.assert_allclose(np.radians(ping["sounding"]["beamAngleReRx_deg"]), swath.beam_rad, atol=1e-6)
    np.testing.assert_allclose(ping["sounding"]["twoWayTravelTime_sec"], swath.travel_time_s, rtol=1e-6)
    np.testing.assert_allclose(ping["sounding"]["y_reRefPoint_m"], swath.sounding_m[:, 1], atol=1e-5)
    assert ping["pingInfo"]["z_waterLevelReRefPoint_m"] == -swath.reference_depth_m
    theirs.FID.seek(theirs.msgoffset[list(theirs.msgtype).index("b'#SKM'")])
    attitude = theirs.read_EMdgmSKM()["sample"]["KMdefault"]
    assert np.radians(attitude["pitch_deg"][0]) == pytest.approx(swath.pitch_rad)


def test_cones_about_any_two_arrays_meet_in_the_beam_that_made_them():
    draw = np.random.default_rng(5)
    for _ in range(50):
        forward, starboard = turned(*draw.uniform(-15, 15, 2), draw.uniform(-180, 180)).T[:2]
        starboard = turned(*draw.uniform(-3, 3, 3)) @ starboard  # received later, by an array that is mounted askew
        beams = np.cross(forward, starboard) + draw.uniform(-0.9, 0.9, (20, 3))
        beams /= np.linalg.norm(beams, axis=1)[:, None]
        beams = beams[beams @ np.cross(forward, starboard) > 0.05]
        found = _where_cones_meet(forward, starboard, beams @ forward, beams @ starboard)
        np.testing.assert_allclose(found, beams, atol=1e-9)


def test_a_map_is_built_from_the_file(small, tmp_path):
    build(tmp_path / "map.bt", [small], voxel=0.25, origin=(43.1, 5.9))
    bed = OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()[:, 2]
    assert np.median(bed) == pytest.approx(-12.1, abs=0.3)


def test_damaged_files_are_refused_with_the_place_and_the_rule(tmp_path):
    whole = kmall()
    second = int.from_bytes(whole[:4], "little")
    first_ping = whole.index(b"#MRZ") - 4
    broken = {
        "empty": (b"", r"at byte 0: not a datagram"),
        "foreign": (b"\x7fELF" * 100, r"at byte 0: not a datagram"),
        "cut": (whole[: second + 30], rf"at byte {second}: a datagram of \d+ bytes: must end within the file"),
        "length": (whole[: second - 4] + b"\0\0\0\0" + whole[second:], r"at byte 0: a datagram must end with"),
        "no_pings": (whole[:first_ping], r"must hold pings \(#MRZ\), has none"),
        "sector": (
            whole[: first_ping + 20 + 4 + 12] + b"\x01\0" + whole[first_ping + 20 + 4 + 14 :],
            rf"at byte {first_ping}: a record must have 144 bytes or more, states 1",
        ),
    }
    for name, (content, rule) in broken.items():
        path = tmp_path / f"{name}.kmall"
        path.write_bytes(content)
        with pytest.raises(ValueError, match=rf"{name}\.kmall': .*{rule}"):
            list(read_kmall(path)[1])


def test_what_a_file_lacks_is_a_warning_with_its_path(tmp_path):
    late = survey(".kmall").replace(b"H=0.000;D=0.000;M=Rotation", b"H=0.000;D=0.010;M=Rotation")
    (tmp_path / "late.kmall").write_bytes(late)
    with pytest.warns(UserWarning, match=r"late.kmall': the delay of its attitudes, 0.010 s, is not applied"):
        read_kmall(tmp_path / "late.kmall")
    (tmp_path / "afloat.gsf").write_bytes(survey(".gsf", depth_m=-0.1))
    with pytest.warns(UserWarning, match=r"afloat.gsf': states no depth of the transducer"):
        list(read_gsf(tmp_path / "afloat.gsf")[1])
