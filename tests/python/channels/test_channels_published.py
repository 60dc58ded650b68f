"""The published protocol: its strings decode, signs are as published, and commands saturate."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from channel_tools import matrix, table
from uwsim import Simulator
from uwsim.channels.families.published import csharp_number
from uwsim.channels.ros import build
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.mapping import ranging


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", speed="max", paused=True) as live:
        live.rov.release()
        yield live


def key(w: float = 0.0, **efforts: float) -> Any:
    """Return a `key` message, with efforts as its position x, y, z and its orientation pitch, roll, yaw, w."""
    x, y, z, *turn = (efforts.get(name, 0.0) for name in ("x", "y", "z", "pitch", "roll", "yaw"))
    return build.pose([x, y, z], (*turn, w))


def test_the_depth_string_decodes_to_the_ping() -> None:
    numbers = {12.31: "12.31", 95.0: "95", 1e-5: "1E-05", math.inf: "Infinity", 1 / 3: "0.3333333"}
    assert {value: csharp_number(value) for value in numbers} == numbers
    for model in (2, 3):
        sim = Simulator("pool", sonar_model=model)
        found = table(sim)
        assert found["modelTrigger"].read(sim).data == str(model)
        assert float(found["hFOV"].read(sim).data) == (85.0 if model < 3 else 170.0)
        decoded = ranging.decode_depth_string(found["depthArray"].read(sim).data, model)
        np.testing.assert_allclose(decoded, found["scan"].read(sim).ranges, rtol=1e-6)  # seven significant digits
        assert np.isfinite(decoded).any()
    other = set(table(Simulator("pool", sonar_model="em2040-04", sonar_frequency_hz=400e3)))
    assert {"scan", "scanPos"} <= other and not {"depthArray", "modelTrigger"} & other


def test_the_scenario_paper_is_served_as_published_without_options() -> None:
    with LiveSimulator("paper", paused=True) as live:
        sim = live.simulator
        found = {channel.name: channel for channel in served_table(live).channels}
        both = {channel.name: channel for channel in served_table(live, wire="both").channels}
        assert set(found) == {
            "clock", "propPos", "scanPos", "depthArray", "modelTrigger", "stateData", "proximitySensor", "hFOV",
            "image/compressed", "images/compressed", "key",
        }  # fmt: skip
        for offered in (found, both):
            assert offered["propPos"].read(sim).position.z == 75.3 + sim.rov.pose.position_world_m[2]
        assert {"odom", "scan", "telemetry"} < set(both)
        station = found["image/compressed"].read(sim)
        assert (station.format, station.header.frame_id) == ("jpeg", "camera")
    with LiveSimulator("pool", paused=True) as live:
        assert {"odom", "propPos"} < {channel.name for channel in served_table(live).channels}


def test_the_state_string_has_the_nine_values_of_the_panel() -> None:
    sim = Simulator("pool")
    sim.advance(1.5)
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, heave=-0.3, yaw=0.3)
    sim.advance(4.0)  # 5.5 s after the start of the scene
    text, panel = table(sim)["stateData"].read(sim).data, sim.rov.telemetry()
    assert text.endswith("a")
    values = [float(value) for value in text[:-1].split("a")]
    expected = [
        panel.speed_m_s, panel.angular_speed_rad_s, panel.temperature_deg_c, panel.pressure_pa / 1000.0, panel.depth_m,
        panel.distance_to_station_m, panel.distance_to_seabed_m, 5.0, panel.battery_percent,
    ]  # fmt: skip
    np.testing.assert_allclose(values, expected, rtol=1e-6)
    assert values[3] == pytest.approx(101.325 + 9.81 * values[4], rel=0.01)  # kPa, in fresh water
    proximity = float(table(sim)["proximitySensor"].read(sim).data)
    assert 10.0 >= proximity == pytest.approx(sim.rov.sensors["proximity_port"].read(), rel=1e-6)


def test_poses_are_offset_by_the_origin_and_the_tilt_is_positive_nose_down() -> None:
    sim = Simulator("pool")
    sim.rov.sonar.aim(-0.5)
    sim.advance(10.0)
    found = table(sim, origin="published")
    pose, head = found["propPos"].read(sim), found["scanPos"].read(sim)
    expected = np.array(sim.rov.pose.world_from_body)
    expected[2, 3] += 75.3
    np.testing.assert_allclose(matrix(pose.position, pose.orientation), expected, atol=1e-12)
    assert head.orientation.y == pytest.approx(math.sin(0.25))  # 0.5 rad about +y
    forward = matrix(head.position, head.orientation)[:3, 0]
    np.testing.assert_allclose(forward, [math.cos(0.5), 0.0, -math.sin(0.5)])
    np.testing.assert_allclose([head.position.x, head.position.y, head.position.z], [0.52, 0.0, -0.22])


def test_efforts_have_the_published_signs_and_saturate(live: LiveSimulator) -> None:
    signs = {"x": 1, "y": -1, "z": 1, "roll": 1, "pitch": 1, "yaw": -1}
    hear = table(live.simulator)["key"].apply
    for axis, (name, sign) in enumerate(signs.items()):
        live.rov.place((0.0, 0.0, -2.5))
        hear(live, key(**{name: 1}))
        live.step(60)
        velocity = live.rov.velocity
        moved = np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])
        assert np.sign(moved[axis]) == sign, name
        assert abs(moved[axis]) > 0.02, name
    hear(live, key(x=4.0, y=-4.0, yaw=math.inf))
    live.step(1)
    np.testing.assert_array_equal(live.rov.effort, [1.0, 1.0, 0.0, 0.0, 0.0, -1.0])


def test_functions_of_the_keyboard(live: LiveSimulator) -> None:
    live.reset()
    rov, lamps = live.rov, live.rov.lamps

    def press(*numbers: float, steps: int = 1) -> float:
        """Press keys one after the other; return the angle by which the sonar has turned since, in degrees."""
        before = rov.sonar.elevation_rad
        for number in numbers:
            table(live.simulator)["key"].apply(live, key(number))
        live.step(steps)
        return math.degrees(rov.sonar.elevation_rad - before)

    assert not rov.released
    press(1, 3)
    assert rov.released and (lamps["front"].on, lamps["down"].on) == (True, False)
    press(2, 5)
    assert (lamps["front"].on, lamps["down"].on) == (False, True)
    turned_deg = press(6, steps=400), press(7, steps=200), press(8, steps=200)  # 5 degrees per second, and held
    assert turned_deg == pytest.approx((-10.0, 0.0, 5.0), abs=0.06)


def test_what_is_no_key_is_refused_whole(live: LiveSimulator) -> None:
    before = len(live.log)
    for message in (key(9.0), key(0.5), key(x=math.nan), key(1.0, pitch=math.nan)):
        with pytest.raises(ValueError, match="key: "):
            table(live.simulator)["key"].apply(live, message)
    live.step(1)
    assert len(live.log) == before
