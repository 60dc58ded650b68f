"""PD0: checksums and layout, and MHKiT's reader, which finds velocities over the bottom and through the water."""

import math
import struct

import numpy as np
import pytest

from command_line import uwsim as uwsim_command
from flown_survey import POOL
from uwsim.flight.raw_options import RawOptions
from uwsim.flight.survey import run_survey
from uwsim.mapping.files.dvl_ensemble import DvlEnsemble, DvlHead, WaterCells
from uwsim.mapping.files.pd0 import Pd0Writer

NOISY = POOL.replace("SONAR", "").replace("earth: {latitude_deg: 43.1, longitude_deg: 5.9}\n", "")

WITH_ADCP = """
builds_on: rov
name: profiler
sensors:
  adcp: {kind: adcp, rate_hz: 2, position_m: [0, 0, -0.3], cell_count: 4, cell_size_m: 0.5, blanking_m: 0.5}
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pd0")
    (folder / "scenario.yaml").write_text(NOISY)
    record = run_survey(folder / "scenario.yaml", folder / "out", raw=folder / "a.pd0", record=folder / "a.mcap",
                        record_topic=("tf_static",), report="none")  # fmt: skip
    return folder, record


def ensembles(data: bytes) -> list[dict[int, bytes]]:
    """Return the blocks of each ensemble by their number, by the published layout."""
    found, at = [], 0
    while at < len(data):
        assert data[at : at + 2] == b"\x7f\x7f"
        (size,) = struct.unpack_from("<H", data, at + 2)
        assert sum(data[at : at + size]) & 0xFFFF == struct.unpack_from("<H", data, at + size)[0]
        offsets = struct.unpack_from(f"<{data[at + 5]}H", data, at + 6)
        ends = [*offsets[1:], size - 2]
        blocks = [data[at + a : at + b] for a, b in zip(offsets, ends, strict=True)]
        found.append({struct.unpack_from("<H", block)[0]: block for block in blocks})
        at += size + 2
    return found


def made(path, cells=None, **changes) -> dict[int, bytes]:
    slant = math.radians(30.0)
    azimuths = np.radians([45.0, 135.0, 225.0, 315.0])
    beams = np.column_stack([math.sin(slant) * np.cos(azimuths), math.sin(slant) * np.sin(azimuths),
                             np.full(4, -math.cos(slant))])  # fmt: skip
    values = {
        "time_ns": 1_577_836_800_250_000_000, "heading_rad": 1.0, "pitch_rad": 0.1, "roll_rad": -0.05, "depth_m": 12.3,
        "sound_speed_m_s": 1490.2, "salinity_psu": 35.0, "temperature_deg_c": 11.25, "pressure_pa": 225_000.0,
        "velocity_m_s": np.array([0.5, -0.2, 0.1]), "beam_velocities_m_s": beams @ [0.5, 0.2, 0.1],
        "beam_ranges_m": np.array([10.0, 11.0, 12.0, 900.0]),
    } | changes  # fmt: skip
    writer = Pd0Writer(path, DvlHead("rov", "dvl", slant, 0.2, cells))
    writer.add(DvlEnsemble(**values))
    writer.close()
    (found,) = ensembles(path.read_bytes())
    return found


def test_an_ensemble_has_the_published_layout(tmp_path):
    found = made(tmp_path / "a.pd0")
    assert {number: len(block) for number, block in found.items()} == {0: 52, 0x80: 57, 0x100: 10, 0x600: 81}
    assert struct.unpack_from("<7B", found[0x80], 4) == (20, 1, 1, 0, 0, 0, 25)
    c, depth_dm, heading, pitch, roll = struct.unpack_from("<3H2h", found[0x80], 14)
    assert (c, depth_dm, heading, pitch, roll) == (1490, 123, 5730, 573, -286)
    bottom = found[0x600]
    low = np.array(struct.unpack_from("<4H", bottom, 16)) + 65536 * np.array(list(bottom[77:81]))
    # RDI's beams 1 to 4 are our first, third, fourth and second; ranges are vertical.
    np.testing.assert_array_equal(low, np.round(100 * np.array([10.0, 12.0, 900.0, 11.0]) * math.cos(math.radians(30))))
    # The bottom goes the other way: starboard, forward, up; four beams that agree have no error velocity.
    assert struct.unpack_from("<4h", bottom, 24) == (200, -500, -100, 0)


def test_what_is_lost_is_marked_bad(tmp_path):
    lost = {"velocity_m_s": np.full(3, np.nan), "beam_velocities_m_s": np.full(4, np.nan),
            "beam_ranges_m": np.full(4, np.nan)}  # fmt: skip
    bottom = made(tmp_path / "a.pd0", **lost)[0x600]
    assert struct.unpack_from("<4H4h", bottom, 16) == (0, 0, 0, 0, *[-32768] * 4)
    fast = made(tmp_path / "b.pd0", velocity_m_s=np.array([40.0, 0.0, 0.0]))[0x600]
    assert struct.unpack_from("<4h", fast, 24)[1] == -32768


def test_cells_and_water_track_have_their_places(tmp_path):
    through = np.array([[0.4, 0.1, 0.0], [0.3, np.nan, 0.0]])
    cells = WaterCells(2, 0.5, 1.25, (1.0, 2.0))
    found = made(tmp_path / "a.pd0", cells, cells_m_s=through, water_track_m_s=through[0])
    assert found[0][9] == 2
    assert struct.unpack_from("<2H", found[0], 12) == (50, 100)  # size and blanking; the first centre is below
    assert struct.unpack_from("<H", found[0], 32) == (125,)
    assert struct.unpack_from("<8h", found[0x100], 2) == (-100, -400, 0, -32768, -32768, -300, 0, -32768)
    assert struct.unpack_from("<3H4h", found[0x600], 44) == (10, 10, 20, -100, -400, 0, -32768)


def test_a_recording_gives_the_same_bytes(flown):
    from uwsim.recording.cli.map_from import from_recording

    folder, _ = flown
    from_recording(source=folder / "a.mcap", out=folder / "map.bt", written=RawOptions(folder / "again.pd0"))
    assert (folder / "again.pd0").read_bytes() == (folder / "a.pd0").read_bytes()


def test_each_sample_is_an_ensemble(flown):
    from uwsim.recording.reader import Recording

    folder, record = flown
    found = ensembles((folder / "a.pd0").read_bytes())
    assert Recording(folder / "a.mcap").complete
    assert len(found) > 0.9 * 5 * record.simulated_s / 2  # 5 Hz, but for the way to the first ping
    numbers = [struct.unpack_from("<H", each[0x80], 2)[0] for each in found]
    assert numbers == list(range(1, len(found) + 1))


def test_mhkit_reads_the_velocity_over_the_bottom(flown):
    dolfyn = pytest.importorskip("mhkit.dolfyn", reason="needs MHKiT, which is not a dependency")
    folder, record = flown
    data = dolfyn.read(str(folder / "a.pd0"))
    assert data.attrs["coord_sys"] == "ship"
    assert data.attrs["sec_between_ping_groups"] == pytest.approx(0.2)
    samples = record.samples["rov"]
    seconds = (data.time.values - np.datetime64("2020-01-01")) / np.timedelta64(1, "s")
    speed = np.hypot(data.vel_bt.values[0], data.vel_bt.values[1])
    true = np.interp(seconds, samples["time_s"], samples["speed_m_s"])
    seen = np.isfinite(speed) & (speed < 10.0)
    assert seen.mean() > 0.9
    assert np.median(np.abs(speed - true)[seen]) < 0.03
    ahead = -data.vel_bt.values[1]  # of the vehicle
    assert np.median(ahead[seen & (true > 0.3)]) > 0.3
    below_m = 9.0 - data.depth.values
    assert np.median(np.abs(data.dist_bt.values.mean(axis=0) - below_m)[seen]) < 0.5


def test_mhkit_reads_the_currents_below_the_vehicle(tmp_path):
    """The bottom's velocity less a cell's is the current's, whatever the vehicle does: 0.2 m/s to the east."""
    dolfyn = pytest.importorskip("mhkit.dolfyn", reason="needs MHKiT, which is not a dependency")
    (tmp_path / "profiler.yaml").write_text(WITH_ADCP)
    moving = NOISY.replace("water: {", "water: {current_world_m_s: [0.2, 0, 0], ").replace(
        "model: rov", "model: profiler.yaml"
    )
    (tmp_path / "scenario.yaml").write_text(moving)
    run_survey(tmp_path / "scenario.yaml", tmp_path / "out", raw=tmp_path / "a.pd0", report="none")
    data = dolfyn.read(str(tmp_path / "a.pd0"))
    np.testing.assert_allclose(data.range.values, [0.75, 1.25, 1.75, 2.25])
    vel, over = data.vel.values[:3], data.vel_bt.values[:3, None]  # starboard, forward, up
    current = vel - over
    heading = np.radians(data.heading.values)
    east = current[0] * np.cos(heading) + current[1] * np.sin(heading)
    north = current[1] * np.cos(heading) - current[0] * np.sin(heading)
    seen = np.isfinite(east) & (np.abs(east) < 5.0)
    assert seen.mean() > 0.3
    assert np.median(east[seen]) == pytest.approx(0.2, abs=0.02)
    assert np.median(north[seen]) == pytest.approx(0.0, abs=0.02)


def test_what_it_does_not_hold_is_refused(tmp_path):
    (tmp_path / "scenario.yaml").write_text(NOISY)
    for option in ("--offsets", "--uncertainty"):
        refused = uwsim_command("survey", "scenario.yaml", "--raw", "a.pd0", option, "roll=0.5", cwd=tmp_path)
        assert refused.returncode != 0
        assert "of which .pd0 has none" in refused.stderr
    assert not (tmp_path / "a.pd0").exists()
    built = uwsim_command("map", "build", "m.bt", "--from", "scenario.yaml", cwd=tmp_path)
    assert built.returncode != 0
