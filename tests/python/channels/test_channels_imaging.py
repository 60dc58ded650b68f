"""Channels of imaging sonars: levels are those at the time stamp, pictures show the latest pings."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from channel_tools import stamp_ns, table
from test_imaging_mount import SONARS, pool_with
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.families import imaging
from uwsim.live import LiveSimulator

PERIOD_S = 0.1


@pytest.fixture
def sim(tmp_path: Path) -> Simulator:
    sim = Simulator(pool_with(tmp_path, SONARS), seed=2)
    sim.rov.place((-2.0, 1.0, -2.0))
    return sim


def levels(message):
    return np.asarray(message.image.data).view("<f4").reshape(len(message.ranges), message.image.beam_count)


def picture(message):
    return np.asarray(Image.open(io.BytesIO(bytes(message.data))).convert("L"), int)


def test_their_streams_are_chosen_as_those_of_cameras(sim):
    whole = Table(sim)
    (found,) = [channel for channel in whole.channels if channel.name == "ahead/picture/compressed"]
    (set_stream,) = [service for service in whole.services if service.name == "ahead/set_stream"]
    seen = []
    with LiveSimulator(sim, speed="max", paused=True) as live:
        assert set_stream.call(live, {"width": 64, "rate_hz": 1.0}) == {"success": True, "message": ""}
        for _ in range(30):
            seen.append(found.read(sim))
            live.step(round(PERIOD_S / sim.step_s))
    said = [message for message in seen if message is not None]
    assert 2 <= len(said) <= 4
    assert all(picture(message).shape[1] == 64 for message in said)


def test_a_forward_looking_sonar_says_the_look_of_its_stamp(sim):
    found = table(sim)
    said, seen = found["ahead/image"].read(sim), sim.rov.imaging_sonars["ahead"].look()
    assert stamp_ns(said) == sim.time_ns
    assert found["ahead/image"].frame_id == said.header.frame_id == "ahead_link"
    np.testing.assert_array_equal(levels(said), seen.level_db)
    port = np.array([-d.y for d in said.beam_directions])  # x up, z ahead, y to starboard
    np.testing.assert_allclose(port, np.sin(seen.bearings_rad))
    shown = picture(found["ahead/picture/compressed"].read(sim))
    assert shown.shape[0] == imaging.HEIGHT
    assert shown[-1, 0] < 30  # outside the sonar's fan
    assert shown.max() > 200


def test_a_waterfall_grows_by_one_ping_a_period_and_begins_anew_when_time_goes_back(sim):
    found, start = table(sim), sim.save_state()

    def rows_after(periods):
        for _ in range(periods):
            shown, said = (found[f"aside/{name}"].read(sim) for name in ("picture/compressed", "image"))
            assert (shown is None) == (said is None)
            sim.advance(PERIOD_S)
        starboard, port = said.beam_directions
        assert said.image.beam_count == 2 and (starboard.y, port.y) == pytest.approx((1.0, -1.0))
        return int((picture(shown).max(axis=1) > 60).sum())  # the background is darker than echoes

    few = rows_after(4)
    assert rows_after(12) >= few + 8
    sim.restore_state(start)
    assert rows_after(4) == few


def test_a_profiler_steps_to_and_fro_and_shows_its_last_echo_in_each_direction(sim):
    found, turned = table(sim), {}
    for _ in range(20):
        said, shown = (found[f"below/{name}"].read(sim) for name in ("image", "picture/compressed"))
        turned[stamp_ns(said)] = [np.arctan2(-d.y, d.z) for d in said.beam_directions]
        sim.advance(PERIOD_S)
    turned = np.concatenate(list(turned.values()))
    steps = np.abs(np.diff(turned))
    np.testing.assert_allclose(steps[steps > 1e-6], imaging.SWEEP_STEP_RAD)
    assert np.ptp(turned) == pytest.approx(2 * imaging.SWEEP_RAD)
    assert picture(shown)[: imaging.HEIGHT // 8].max() < picture(shown).max() - 100  # the bed is drawn below, not above
