"""Seabeds by angle, multipath, targets and the water column, from a scenario to pings, figures and channels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels.table import Table
from uwsim.instruments.acoustics import SEABEDS, seabed_backscatter_db
from uwsim.scenario import load
from uwsim.scenario.read.errors import ScenarioError

SEEP = """
name: seep
terrain: {source: noise, size_m: [100, 100], spacing_m: 10, bed_depth_m: 20, hill_height_m: 0}
ground: {bed: sand, seabed: medium_sand, relief: 0}
water: {volume_strength_db: -80}
water_targets:
  - {kind: school, name: cod, position_m: [0.5, 6, -8], size_m: [1, 6, 3], count: 400}
  - {kind: seep, name: vent, position_m: [0.5, -5, -20], height_m: 15, count: 2000}
vehicles:
  - name: rov
    model: rov
    start: {position_m: [0, 0, -2]}
    sonar: {model: 2, mode: physics, tilt_deg: 90, multipath: true, water_column: true}
"""


def scenario(folder: Path, text: str = SEEP) -> Path:
    path = folder / "seep.yaml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def seep(tmp_path_factory: pytest.TempPathFactory) -> Simulator:
    return Simulator(scenario(tmp_path_factory.mktemp("seep")))


def power_within(ping: Any, angles_deg: tuple[float, float], ranges_m: tuple[float, float]) -> float:
    """Return the mean power of the water column's samples within angles and ranges."""
    angles, ranges = np.degrees(ping.angles_rad), ping.water_column_ranges_m
    rows = (angles > angles_deg[0]) & (angles < angles_deg[1])
    columns = (ranges > ranges_m[0]) & (ranges < ranges_m[1])
    return float((10.0 ** (ping.water_column[rows][:, columns].astype(float) / 10.0)).mean())


def test_the_water_column_shows_fish_bubbles_and_the_second_echo(seep: Simulator) -> None:
    ping: Any = seep.rov.sonar.ping()
    head_z_m = float(ping.world_from_sonar[2, 3])
    height_m = 20.0 + head_z_m
    beams, samples = ping.water_column.shape
    assert beams == len(ping.ranges_m) and samples == len(ping.water_column_ranges_m) <= 4096
    water = power_within(ping, (-5.0, 5.0), (5.0, 15.0))
    to_fish = np.degrees(np.arctan2(6.0, head_z_m + 8.0))
    assert power_within(ping, (to_fish - 10, to_fish + 10), (4.0, 12.0)) > 10.0 * water
    assert power_within(ping, (-30.0, -17.0), (10.0, 17.0)) > 2.0 * water
    second_m = 2.0 * height_m - head_z_m
    near = power_within(ping, (-1.0, 1.0), (second_m - 0.1, second_m + 0.1))
    assert near > 10.0 * power_within(ping, (-1.0, 1.0), (second_m - 3.0, second_m - 1.0))


def test_it_changes_nothing_else_and_is_computed_only_on_request(seep: Simulator) -> None:
    with_it: Any = seep.rov.sonar.ping()
    without: Any = seep.rov.sonar.ping(water_column=False)
    assert without.water_column is None and without.water_column_ranges_m is None
    assert np.array_equal(with_it.ranges_m, without.ranges_m)
    assert np.array_equal(with_it.intensity_db, without.intensity_db)
    assert any(axes.images for axes in with_it.plot().axes)
    pool = Simulator("pool")
    assert not [channel for channel in Table(pool).channels if channel.name == "water_column"]
    with pytest.raises(ValueError, match="water_column = True: is for `mode: physics` only"):
        pool.rov.sonar.ping(water_column=True)


def test_a_channel_offers_it_with_the_samples_of_the_ping(seep: Simulator) -> None:
    (channel,) = [channel for channel in Table(seep).channels if channel.name == "water_column"]
    message, ping = channel.read(seep), seep.rov.sonar.ping()
    levels = np.asarray(message.image.data).view("<f4").reshape(len(message.ranges), message.image.beam_count)
    assert np.array_equal(levels.T, ping.water_column)  # type: ignore[attr-defined]
    assert message.ping_info.sound_speed > 1400.0  # at the head
    assert channel.delivery.on_request and channel.type == "marine_acoustic_msgs/msg/ProjectedSonarImage"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("seabed: medium_sand", "seabed: granite", "ground.seabed"),
        ("mode: physics, ", "", "is for `mode: physics` only"),
        ("volume_strength_db: -80", "volume_strength_db: 3", "water.volume_strength_db"),
        ("count: 400", "count: 0", "must be in"),
        ("name: vent", "name: cod", "is already in use"),
    ],
)
def test_bad_values_are_refused_by_name(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        load(scenario(tmp_path, SEEP.replace(old, new)))


def test_a_seabed_replaces_lamberts_law_by_its_own_curve(tmp_path: Path) -> None:
    """The mean level of a beam at an angle differs from Lambert's by the difference of the two laws."""
    plain = SEEP.replace(", water_column: true", "").replace("multipath: true", "noise: {false_detections: false}")
    plain = plain[: plain.index("water:")] + plain[plain.index("vehicles:") :]
    by_angle = Simulator(scenario(tmp_path, plain)).rov.sonar
    lambert = Simulator(scenario(tmp_path, plain.replace("seabed: medium_sand", "strength_db: -10"))).rov.sonar
    one: Any = by_angle.ping()
    other: Any = lambert.ping()
    both = one.valid & other.valid
    for low_deg, high_deg in ((0.0, 2.0), (30.0, 34.0)):
        rows = both & (np.abs(np.degrees(one.angles_rad)) > low_deg) & (np.abs(np.degrees(one.angles_rad)) < high_deg)
        grazing = np.pi / 2 - np.abs(one.angles_rad[rows])
        model_db = seabed_backscatter_db("medium_sand", grazing, 100e3) - (-10.0 + 20.0 * np.log10(np.sin(grazing)))
        np.testing.assert_allclose(
            np.mean(one.intensity_db[rows] - other.intensity_db[rows]), np.mean(model_db), atol=0.5
        )


def test_seabeds_are_valid_from_10_to_100_khz() -> None:
    assert SEABEDS[0] == "rough_rock" and len(SEABEDS) == 23
    assert seabed_backscatter_db("clay", [[0.1, 0.2]], 30e3).shape == (1, 2)
    with pytest.raises(ValueError, match="frequency_hz = 200000 Hz: must be in"):
        seabed_backscatter_db("clay", 0.5, 200e3)
    with pytest.raises(ValueError, match="grazing_rad"):
        seabed_backscatter_db("clay", 2.0, 30e3)
