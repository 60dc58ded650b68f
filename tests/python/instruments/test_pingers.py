"""Pingers and hydrophones: closed forms of delay, level and echo, noise by its source, and what the guide promises."""

import csv
import wave
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwsim
from uwsim import _core
from uwsim.channels import channels
from uwsim.exercises import load_exercise
from uwsim.exercises.exercise import PropShift
from uwsim.instruments.acoustics.hydrophones import HydrophonePing
from uwsim.instruments.acoustics.pinger_sound import image_sources
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.spec.pinger import Pool

PHONES = ((0, 0, 0), (0.02, 0, 0), (0, 0.02, 0), (0, 0, 0.02))
PINGER: dict[str, Any] = {"name": "east", "position_m": (17, 11, -5), "frequency_hz": 30_000.0, "period_s": 1.0}
QUIET = {"noise_db": -100.0}


def site(*pingers: dict[str, Any], yaw_deg: float = 20.0, array: dict[str, Any] | None = None, **more: Any) -> Any:
    model = {
        "builds_on": "bluerov2_heavy",
        "sensors": {"bearing": {"kind": "bearing", "rate_hz": 10}},
        "hydrophones": {"array": {"phones_m": PHONES, **(array or {})}},
    }
    return {
        "name": "site",
        "water": {"surface_temperature_deg_c": 15, "bottom_temperature_deg_c": 15},
        "terrain": {"source": "noise", "size_m": [60, 50], "bed_depth_m": 15, "hill_height_m": 0},
        "pingers": pingers or (PINGER,),
        "vehicles": [{"name": "rov", "start": {"position_m": [0, 0, -3], "yaw_deg": yaw_deg}, "model": model}],
        **more,
    }


def heard(sim: uwsim.Simulator, after_s: float = 1.025) -> HydrophonePing:
    sim.advance(after_s)
    ping = sim.rov.hydrophones["array"].listen()
    assert ping is not None
    return ping


def amplitudes(ping: HydrophonePing, frequency_hz: float) -> Any:
    """Return the complex amplitude at each phone, before the first echo."""
    first = int(np.argmax(np.abs(ping.samples[:, 0]) > 0.5 * np.abs(ping.samples).max()))
    direct = slice(first, first + 150)
    return np.exp(-2j * np.pi * frequency_hz * ping.times_s[direct]) @ ping.samples[direct]


@pytest.mark.parametrize("yaw_deg", [-150, -60, 20, 110])
def test_phase_finds_a_pinger_within_two_degrees_at_twenty_metres(yaw_deg: float) -> None:
    with uwsim.Simulator(site(yaw_deg=yaw_deg)) as sim:
        ahead, port, _ = np.angle((lambda each: each[1:] / each[0])(amplitudes(heard(sim), 30_000)))
        x, y, _ = sim.rov.pose.world_from_body[:3, :3].T @ (PINGER["position_m"] - sim.rov.pose.position_world_m)
    off = np.angle(np.exp(1j * (np.arctan2(port, ahead) - np.arctan2(y, x))))
    assert abs(np.degrees(off)) < 2.0, np.degrees(off)


def test_delays_between_phones_are_exact_and_the_level_falls_by_spreading_and_absorption() -> None:
    with uwsim.Simulator(site(array=QUIET)) as sim:
        ping = heard(sim)
        pose = sim.rov.pose
        phones = PHONES @ pose.world_from_body[:3, :3].T + pose.position_world_m
        water, middle_m = sim.world.water, -4.0
        speed = _core.sound_speed_profile(water).at(-middle_m)
        alpha = _core.absorption_db_km(30e3, water.temperature_deg_c(middle_m), water.salinity_at_psu(middle_m), 4.0)
    ranges = np.linalg.norm(phones - PINGER["position_m"], axis=1)
    found = amplitudes(ping, 30_000)
    lead_s = np.angle(found[1:] / found[0]) / (2 * np.pi * 30_000)
    np.testing.assert_allclose(lead_s, (ranges[0] - ranges[1:]) / speed, atol=1e-7)  # a tenth of a microsecond
    first = int(np.argmax(np.abs(ping.samples[:, 0]) > 0.5 * np.abs(ping.samples).max()))
    assert ping.times_s[first] == pytest.approx(1.0 + ranges[0] / speed, abs=2e-4)  # the burst rises over 0.1 ms
    direct = 1e6 * ping.pascals_per_count * ping.samples[first + 50 : first + 200].astype(float)
    level_db = 10 * np.log10((direct**2).mean(axis=0))
    np.testing.assert_allclose(level_db, 170 - 20 * np.log10(ranges) - 1e-3 * alpha * ranges, atol=0.05)


def test_a_pool_returns_the_sound_of_images() -> None:
    pool = Pool(size_m=(25, 16), depth_m=2.4, walls=0.7, floor=0.6, surface=-0.9, order=2)
    source, point = np.array([9.5, 1.5, -2.2]), np.array([-11.0, 0.5, -0.6])
    (lengths,), gains = image_sources(pool, source, point[None])
    found = sorted(zip(lengths, gains, strict=True))
    mirrors = [(0, 12.5, 0.7), (0, -12.5, 0.7), (1, 8.0, 0.7), (1, -8.0, 0.7), (2, 0.0, -0.9), (2, -2.4, 0.6)]

    def mirrored(place: Any, axis: int, at: float) -> Any:
        return np.where(np.arange(3) == axis, 2 * at - place, place)

    # All images of images by brute force; those of two different axes are the same in either order.
    wanted = {(*np.round(source, 9), 1.0)}
    for axis, at, gain in mirrors:
        once = mirrored(source, axis, at)
        wanted.add((*np.round(once, 9), gain))
        wanted |= {
            (*np.round(mirrored(once, a, p), 9), round(gain * g, 9)) for a, p, g in mirrors if (a, p) != (axis, at)
        }
    by_hand = sorted((float(np.linalg.norm(np.array(each[:3]) - point)), each[3]) for each in wanted)
    assert len(found) == len(by_hand) == 25
    np.testing.assert_allclose(found, by_hand, atol=1e-9)


def test_images_are_those_of_pyroomacoustics() -> None:
    judge = pytest.importorskip("pyroomacoustics", reason="pyroomacoustics judges image sources")
    pool = Pool(size_m=(25, 16), depth_m=2.4, walls=0.7, floor=0.7, surface=0.7, order=3)
    room = judge.ShoeBox([25, 16, 2.4], fs=48_000, materials=judge.Material(1 - 0.7**2), max_order=3)
    source, point = np.array([22.0, 9.5, 0.2]), np.array([1.5, 8.5, 1.8])
    room.add_source(source)
    room.add_microphone(point[:, None])
    room.image_source_model()
    one, low = room.sources[0], pool.bounds_m()[0]
    (lengths,), gains = image_sources(pool, source + low, point[None] + low)
    theirs = np.column_stack([np.linalg.norm(one.images - point[:, None], axis=0), one.damping[0]])
    ours = np.column_stack([lengths, gains])
    np.testing.assert_allclose(ours[np.argsort(lengths)], theirs[np.argsort(theirs[:, 0])], atol=1e-5)


def test_echoes_of_a_pool_are_heard_when_their_images_arrive() -> None:
    box = {"size_m": (60, 50), "depth_m": 15, "walls": 0.0, "floor": 0.0, "surface": -0.95, "order": 1}
    short = {**PINGER, "pulse_s": 2e-4, "frequency_hz": 60_000.0}
    with uwsim.Simulator(site(short, array=QUIET, sound={"pool": box})) as sim:
        ping = heard(sim)
        speed = _core.sound_speed_profile(sim.world.water).at(7.5)
    times = 1.0 + np.linalg.norm([(17, 11, -2), (17, 11, 8)], axis=1) / speed
    loud = np.abs(ping.samples[:, 0].astype(float))
    at = [loud[np.abs(ping.times_s - each - 1e-4) < 1e-4].max() for each in times]
    assert at[1] / at[0] == pytest.approx(0.95 * 20.347 / 21.772, rel=0.03)  # besides absorption
    between = (ping.times_s > times[0] + 3e-4) & (ping.times_s < times[1] - 1e-5)
    assert between.sum() > 300 and loud[between].max() < 0.02 * at[0]


def test_noise_is_wenzs_and_the_electronics_and_a_loud_pinger_clips() -> None:
    far = {**PINGER, "level_db": 60.0}
    array = {"noise_db": 40.0, "gain_db": 80.0, "after_s": 0.1}
    with uwsim.Simulator(site(far, array=array)) as sim:
        ping = heard(sim)
    pressure = 1e6 * ping.pascals_per_count * ping.samples.astype(float)
    power = (np.abs(np.fft.rfft(pressure, axis=0)) ** 2).mean(axis=1) * 2 / (len(pressure) * ping.rate_hz)
    frequencies = np.fft.rfftfreq(len(pressure), 1 / ping.rate_hz)
    for frequency in (5e3, 30e3, 100e3, 200e3):
        near = np.abs(frequencies - frequency) < 0.1 * frequency
        wenz = 10 ** (0.1 * _core.ambient_noise_db_hz(frequency, 5.0, 0.5))
        assert 10 * np.log10(power[near].mean() / (wenz + 1e4)) == pytest.approx(0.0, abs=0.4), frequency
    assert ping.clipped == 0
    with uwsim.Simulator(site({**PINGER, "level_db": 200.0}, array=array)) as sim:
        loud = heard(sim)
    assert loud.clipped > 100 and (loud.samples.min(), loud.samples.max()) == (-32768, 32767)


def test_samples_depend_on_seed_and_time_alone_and_are_saved(tmp_path: Path) -> None:
    def run(seed: int, *, early: bool) -> HydrophonePing:
        with uwsim.Simulator(site(), seed=seed) as sim:
            assert sim.rov.hydrophones["array"].listen() is None
            if early:
                heard(sim, 1.2)
            return heard(sim, 0.825 if early else 2.025)

    first, again, other = run(1, early=False), run(1, early=True), run(2, early=False)
    assert np.array_equal(first.samples, again.samples) and not np.array_equal(first.samples, other.samples)
    first.save(tmp_path / "ping.wav")
    with wave.open(str(tmp_path / "ping.wav")) as file:
        assert (file.getnchannels(), file.getframerate(), file.getnframes()) == (4, 500_000, len(first.samples))
        assert file.readframes(10) == first.samples[:10].astype("<i2").tobytes()
    first.save(tmp_path / "ping.csv")
    rows = list(csv.reader((tmp_path / "ping.csv").open()))
    assert rows[0] == ["time_s", "phone_0", "phone_1", "phone_2", "phone_3"] and len(rows) == 1 + len(first.samples)
    with pytest.raises(ValueError, match=r"must end in \.wav or \.csv"):
        first.save(tmp_path / "ping.txt")


def test_the_bearing_is_valid_once_for_each_ping_and_points_at_the_pinger() -> None:
    low = {**PINGER, "name": "low", "frequency_hz": 150.0 * 2, "position_m": (-10, 0, -3), "first_s": 0.5}
    scenario = site(PINGER, low)
    scenario["vehicles"][0]["model"]["sensors"]["bearing"]["low_hz"] = 1000
    with uwsim.Simulator(scenario) as sim:
        stream = sim.rov.sensors["bearing"].stream()
        sim.advance(3.5)
        found = stream.take()
        rows = found.readings[found.valid]
        assert len(rows) == 4 and len(found.valid) == 35
        pose, place = sim.rov.pose, np.array(PINGER["position_m"])
        x, y, z = pose.world_from_body[:3, :3].T @ (place - pose.position_world_m)
        np.testing.assert_allclose(rows[-1][:2], (np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))), atol=0.002)
        assert rows[-1][2] == pytest.approx(170 - 20 * np.log10(20.2), abs=0.3) and rows[-1][3] == 30_000


def test_topics_offer_each_ping_once() -> None:
    with uwsim.Simulator(site()) as sim:
        table = {each.name: each for each in channels(sim)}
        array, bearing = table["rov/array" if "rov/array" in table else "array"], table["bearing"]
        assert array.read(sim) is None
        ping = heard(sim, 1.1)
        message = array.read(sim)
        assert np.array_equal(message.samples.reshape(-1, message.phones), ping.samples)
        assert message.header.frame_id.endswith("array_link") and message.rate == 500_000
        sim.advance(0.5)
        assert array.read(sim) is message and bearing.read(sim) is None
        sim.advance(0.5)
        assert array.read(sim) is not message
        way = bearing.read(sim).vector
        assert np.linalg.norm([way.x, way.y, way.z]) == pytest.approx(1.0)


def test_a_props_pinger_moves_with_the_layout_and_takes_a_frequency() -> None:
    exercise, shift = load_exercise("pool-course"), PropShift(prop="pinger", x_m=(-2, 2), y_m=(-1, 1))
    made = [exercise.model_copy(update={"seed": seed, "layout": [shift]}).made_scenario() for seed in (1, 2)]
    first, second = ([(one.name, one.position_m) for one in each.pingers] for each in made)
    assert [name for name, _ in first] == ["pinger_pinger"] and first != second
    prop = {"name": "near", "model": "pinger", "position_m": (3, 2, -6), "frequency_hz": 28_000}
    (east, near) = load(site(props=[prop])).pingers
    assert east.frequency_hz == 30_000 and near.frequency_hz == 28_000
    assert near.name == "near_pinger" and near.position_m == (3, 2, -5.89)


@pytest.mark.parametrize(
    ("pingers", "more", "message"),
    [
        ([{**PINGER, "position_m": (0, 0, 1)}], {}, r"pingers\[0\].position_m.*must be under water"),
        ([PINGER, PINGER], {}, r"pingers\[1\].name.*already in use"),
        ([{**PINGER, "pulse_s": 1.0, "period_s": 0.5}], {}, r"pulse_s.*must be less than period_s"),
        ([PINGER], {"sound": {"pool": {"size_m": (10, 10), "depth_m": 6}}}, r"position_m.*must be in sound.pool"),
        ([PINGER], {"array": {"phones_m": [(0, 0, 0)] * 5}}, r"phones_m"),
    ],
)
def test_mistakes_are_one_line(pingers: list[dict[str, Any]], more: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as error:
        load(site(*pingers, **more))
    assert "\n" not in str(error.value).strip()
