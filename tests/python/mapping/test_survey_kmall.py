"""Surveys in .kmall: pykmall and gsfu's converter read them, and grid them from the travel times to our own bed."""

import contextlib
import io
import math
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from tests.fuzz.surveys import survey

from flown_survey import LATITUDE, LONGITUDE, grids_apart_m, traced, traced_from_travel_times
from uwsim import _core
from uwsim.cli.map_build import build
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files.gsf_read import read_gsf
from uwsim.mapping.files.kmall import KmallWriter
from uwsim.mapping.files.kmall_read import _where_cones_meet, read_kmall
from uwsim.mapping.files.swath import SoundSpeeds, SurveyHead

KINDS = ("#SPO", "#SKM", "#SDE", "#SVT", "#MRZ")
METRES = np.array([111_112.2, 81_401.2])  # per degree of latitude and longitude at 43.1 degrees north, GRS 80


@pytest.fixture(scope="module")
def reader(bent):
    kmall = pytest.importorskip("KMALL.kmall", reason="needs pykmall")
    found = kmall.kmall(str(bent.raw))
    found.index_file()
    return found


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


def datagrams(reader, kind, method):
    for offset, name in zip(reader.msgoffset, reader.msgtype, strict=True):
        if name == f"b'{kind}'":
            reader.FID.seek(offset)
            yield getattr(reader, method)()


def test_pykmall_verifies_the_file(bent, reader):
    command = [sys.executable, "-W", "ignore", "-m", "KMALL.kmall", "-f", str(bent.raw), "-V"]
    verified = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    assert verified.stderr == ""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        (install,) = datagrams(reader, "#IIP", "read_EMdgmIIP")
        (runtime,) = datagrams(reader, "#IOP", "read_EMdgmIOP")
        stated = reader.translate_installation_parameters_todict(install["install_txt"])
        reader.translate_runtime_parameters_todict(runtime["runtime_txt"])
    text = verified.stdout + said.getvalue()
    assert "Packet statistics:" in text
    for complaint in ("warning", "error", "missing mrz", "unable", "not enough", "not interpreted", "traceback"):
        assert complaint not in text.lower(), text
    assert reader.check_ping_count()[2:] == (0, 0)
    counts = {kind: sum(name == f"b'{kind}'" for name in reader.msgtype) for kind in KINDS}
    assert set(counts.values()) == {len(bent.record.path_world_m)}
    assert stated["sonar_model_number"] == "EM2040"
    assert stated["active_position_system_number"] == "position_1"


def test_travel_times_read_by_pykmall_grid_to_our_own_bed(bent, reader):
    installed = next(datagrams(reader, "#IIP", "read_EMdgmIIP"))["install_txt"]
    head = dict(pair.split("=") for pair in installed.split("TRAI_RX1:")[1].split(",")[0].split(";"))
    offset = np.array([float(head[name]) for name in "XYZ"])
    mount = turned(*(float(head[name]) for name in "RPH"))
    profile = next(datagrams(reader, "#SVP", "read_EMdgmSVP"))["sensorData"]
    profile = np.array(profile["depth_m"]), np.array(profile["soundVelocity_mPerSec"])
    attitudes = {}
    for each in datagrams(reader, "#SKM", "read_EMdgmSKM"):
        sample = each["sample"]["KMdefault"]
        attitudes[each["header"]["dgtime"]] = [sample[f"{name}_deg"][0] for name in ("roll", "pitch", "heading")]
    found, misfits = [], []
    for ping in datagrams(reader, "#MRZ", "read_EMdgmMRZ"):
        info = ping["pingInfo"]
        sounding = {name: np.array(values) for name, values in ping["sounding"].items()}
        seen = sounding["detectionType"] == 0
        across = np.radians(sounding["beamAngleReRx_deg"][seen])
        level = turned(*attitudes[ping["header"]["dgtime"]])
        rays = np.column_stack([0 * across, -np.sin(across), np.cos(across)]) @ (level @ mount).T
        place = np.array([info["latitude_deg"] - LATITUDE, info["longitude_deg"] - LONGITUDE]) * METRES
        start = level @ offset
        depth = start[2] - info["z_waterLevelReRefPoint_m"]
        assert depth == pytest.approx(info["txTransducerDepth_m"], abs=1e-4)
        out, down = traced(depth, rays[:, 2], sounding["twoWayTravelTime_sec"][seen], *profile).T
        azimuth = np.arctan2(rays[:, 1], rays[:, 0])
        north, east = place[0] + start[0] + out * np.cos(azimuth), place[1] + start[1] + out * np.sin(azimuth)
        found.append(np.column_stack([east, north, -down]))
        stated = np.column_stack([
            (info["longitude_deg"] - LONGITUDE + sounding["deltaLongitude_deg"]) * METRES[1],
            (info["latitude_deg"] - LATITUDE + sounding["deltaLatitude_deg"]) * METRES[0],
            info["z_waterLevelReRefPoint_m"] - sounding["z_reRefPoint_m"],
        ])[seen]  # fmt: skip
        misfits.append(np.abs(stated - found[-1]).max())
    assert max(misfits) < 0.01
    apart_m = grids_apart_m(bent.own_soundings, np.concatenate(found))
    assert len(apart_m) > 100
    assert apart_m.max() < 0.01


def test_gsfus_converter_makes_a_gsf_of_the_same_beams(bent, tmp_path):
    pytest.importorskip("KMALL.kmall", reason="needs pykmall")
    from GSFU.kmall2gsf import convert

    assert convert(str(bent.raw), str(tmp_path / "theirs.gsf")) == len(bent.record.path_world_m)
    for ours, theirs in zip(read_gsf(bent.gsf)[1], read_gsf(tmp_path / "theirs.gsf")[1], strict=True):
        seen = ours.is_detected
        np.testing.assert_allclose(theirs.travel_time_s[seen], ours.travel_time_s[seen], atol=6e-6)  # its step is 10 us
        below = [0.0, 0.0, ours.reference_depth_m]  # their depths are those below the vehicle
        np.testing.assert_allclose(theirs.sounding_m[seen] + below, ours.sounding_m[seen], atol=0.011)


def test_another_reader_has_the_pings_with_their_places_attitudes_and_soundings(tmp_path):
    name = "themachinethatgoesping.echosounders"
    kmall = pytest.importorskip(name, reason="needs themachinethatgoesping, which is not a dependency").kmall
    (tmp_path / "small.kmall").write_bytes(survey(".kmall"))
    pings = kmall.KMALLFileHandler([str(tmp_path / "small.kmall")]).get_pings()
    swaths = list(read_kmall(tmp_path / "small.kmall")[1])
    assert len(pings) == len(swaths) == 2
    for ping, swath in zip(sorted(pings, key=lambda each: each.get_timestamp()), swaths, strict=True):
        here, found = ping.get_geolocation(), ping.bottom.get_xyz()
        assert ping.get_timestamp() == pytest.approx(1e-9 * swath.time_ns)
        assert (here.latitude, here.longitude) == pytest.approx((swath.latitude_deg, swath.longitude_deg))
        attitude = np.degrees([swath.roll_rad, swath.pitch_rad, swath.heading_rad])
        assert (here.roll, here.pitch, here.yaw) == pytest.approx(attitude, abs=1e-4)
        below = swath.sounding_m - [0.0, 0.0, swath.reference_depth_m]
        np.testing.assert_allclose(np.column_stack([found.x, found.y, found.z]), below, atol=1e-5)
        np.testing.assert_allclose(ping.bottom.get_two_way_travel_times(), swath.travel_time_s, rtol=1e-6)


def test_a_flights_kmall_and_its_recordings_gsf_have_the_same_swaths_whose_travel_times_lead_to_soundings(bent):
    head, swaths = read_kmall(bent.raw)
    profile = _core.SoundSpeedProfile(head.profile.depths_m, head.profile.speeds_m_s)
    for ours, theirs in zip(read_gsf(bent.gsf)[1], swaths, strict=True):
        seen = ours.is_detected
        assert theirs.time_ns == pytest.approx(ours.time_ns, abs=1000)
        np.testing.assert_array_equal(theirs.is_detected, seen)
        np.testing.assert_allclose(theirs.travel_time_s[seen], ours.travel_time_s[seen], rtol=3e-7, atol=2e-8)
        np.testing.assert_allclose(theirs.axes[seen], ours.axes[seen], atol=2e-4)  # GSF has 0.006 deg
        np.testing.assert_allclose(theirs.sounding_m[seen], ours.sounding_m[seen], atol=3e-4)
        np.testing.assert_allclose(theirs.transducer_m, ours.transducer_m, atol=2e-4)
        np.testing.assert_allclose(traced_from_travel_times(theirs, profile), theirs.sounding_m[seen], atol=1e-3)


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


def of_revision_f(data: bytes) -> bytes:
    """Return a file without what Rev G to I added to a ping (8 bytes) and to its sector (12 bytes)."""
    found, at = [], 0
    while at < len(data):
        size = int.from_bytes(data[at : at + 4], "little")
        body = bytearray(data[at + 4 : at + size - 4])
        if body[:4] == b"#MRZ":
            ping = 16 + 4 + 12
            body[ping : ping + 2] = (144).to_bytes(2, "little")
            body[ping + 94 : ping + 96] = (36).to_bytes(2, "little")
            del body[ping + 152 + 36 : ping + 152 + 48], body[ping + 144 : ping + 152]
        length = (len(body) + 8).to_bytes(4, "little")
        found.append(length + body + length)
        at += size
    return b"".join(found)


def test_older_revisions_are_read(bent, tmp_path):
    (tmp_path / "f.kmall").write_bytes(of_revision_f(bent.raw.read_bytes()))
    for old, new in zip(read_kmall(tmp_path / "f.kmall")[1], read_kmall(bent.raw)[1], strict=True):
        np.testing.assert_array_equal(old.axes, new.axes)
        np.testing.assert_array_equal(old.sounding_m, new.sounding_m)


def test_a_map_is_built_from_the_file(bent, tmp_path):
    build(tmp_path / "map.bt", [bent.raw], voxel=0.25, origin=(LATITUDE, LONGITUDE))
    bed = OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()[:, 2]
    assert np.median(bed) == pytest.approx(-9.0, abs=0.3)


def test_damaged_files_are_refused_with_the_place_and_the_rule(bent, tmp_path):
    whole = bent.raw.read_bytes()
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


def test_more_beams_than_a_datagram_holds_are_refused(tmp_path):
    levels = SoundSpeeds(np.array([0.0, 20.0]), np.array([1500.0, 1500.0]))
    head = SurveyHead("rov", "wide", 4e5, 1025, 50.0, np.zeros(3), np.zeros(3), levels, "")
    writer = KmallWriter(tmp_path / "wide.kmall", head)
    with pytest.raises(ValueError, match=r"1025 beams: \.kmall holds up to 1024"):
        writer.add(SimpleNamespace(travel_time_s=np.zeros(1025)))
    writer.discard()
    assert not list(tmp_path.iterdir())
