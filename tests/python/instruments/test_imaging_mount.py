"""Imaging sonars in a vehicle's YAML file: they move with the vehicle, and errors name the key."""

import re
from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.instruments.sonars import imaging
from uwsim.scenario.read.assets import assets_folder

POOL = assets_folder() / "scenarios" / "pool.yaml"
SONARS = """
imaging_sonars:
  ahead: {kind: forward_looking, position_m: [0.5, 0.1, -0.2], yaw_pitch_roll_deg: [0, 20, 0], range_max_m: 10,
          range_bins: 100, beams: 32, field_of_view_deg: 60, rays_per_column: 64}
  aside: {kind: side_scan, range_max_m: 15, range_bins: 300}
  below: {kind: single_beam, yaw_pitch_roll_deg: [0, 90, 0], range_max_m: 10, range_bins: 1000, looks: 8}
"""


def pool_with(tmp_path: Path, sonars: str) -> Path:
    """Return the pool with a vehicle that carries these sonars."""
    text = (assets_folder() / "vehicles" / "rov.yaml").read_text()
    (tmp_path / "diver.yaml").write_text(re.sub(r"\nimaging_sonars:\n(  .*\n)+", "\n", text) + sonars)
    path = tmp_path / "scenario.yaml"
    path.write_text(POOL.read_text().replace("model: rov", "model: diver.yaml"))
    return path


def test_they_ping_from_the_vehicles_pose(tmp_path: Path) -> None:
    sim = Simulator(pool_with(tmp_path, SONARS), seed=2)
    turned = (0.0, 0.0, np.sin(0.4), np.cos(0.4))
    sim.rov.place((-2.0, 1.0, -2.0), turned)
    sonars = sim.rov.imaging_sonars
    assert list(sonars) == ["ahead", "aside", "below"]

    image = sonars["ahead"].look()
    assert image.level_db.shape == (100, 32)
    assert np.degrees(image.bearings_rad[-1]) == pytest.approx(30.0)
    mount = imaging.pose_matrix((0.5, 0.1, -0.2), pitch_rad=np.radians(20.0))
    assert image.world_from_sonar == pytest.approx(sim.rov.pose.world_from_body @ mount)

    assert sonars["aside"].line().altitude_m == pytest.approx([3.0], abs=0.1)
    below = sonars["below"].profile([0.0])
    assert below.points_world_m[0] == pytest.approx([-2.0, 1.0, -5.0], abs=0.05)

    assert np.array_equal(image.level_db, sonars["ahead"].look().level_db), "at one time it is the same picture"
    sim.step()
    assert not np.array_equal(image.level_db, sonars["ahead"].look().level_db)


def test_a_method_of_another_kind_is_refused(tmp_path: Path) -> None:
    sonars = Simulator(pool_with(tmp_path, SONARS)).rov.imaging_sonars
    for method, words in (
        (sonars["ahead"].line, r"imaging_sonars\['ahead'\] is ForwardLooking: must be SideScan"),
        (sonars["below"].look, "must be ForwardLooking"),
        (lambda: sonars["aside"].profile([0.0]), "must be SingleBeam"),
    ):
        with pytest.raises(ValueError, match=words):
            method()
    with pytest.raises(ValueError, match="wreck"):
        Simulator(pool_with(tmp_path, "\nimaging_sonars:\n  eye: {kind: side_scan, strengths_db: {wreck: -5}}\n"))


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        ("kind: sonar", "kind = 'sonar': must be one of forward_looking"),
        ("kind: side_scn", "did you mean 'side_scan'"),
        ("kind: side_scan, beams: 12", "beams: unknown key"),
        ("kind: forward_looking, beams: 0", r"beams = 0: must be in \[1, 4096\]"),
        ("kind: forward_looking, beams: many", "beams = 'many': must be a number"),
        ("kind: forward_looking, beams: 12.5", "beams = 12.5: must be a whole number"),
        ("kind: forward_looking, time_varied_gain: 3", "time_varied_gain = 3: must be true or false"),
        ("kind: forward_looking, field_of_view_deg: 400", r"field_of_view_deg = 400 deg: must be in \(0, 360\] deg"),
        ("kind: forward_looking, frequency_hz: -5", r"frequency_hz = -5.*: must be in"),
        ("kind: single_beam, strengths_db: 3", "strengths_db = 3: must be a strength in dB for each surface"),
        ("kind: single_beam, figures: {wings: 2}", "figures.wings: unknown parameter of a single_beam"),
        ("kind: single_beam, figures: {looks: 17}", r"looks = 17: must be in \[0, 16\]"),
        ("kind: single_beam, position_m: [0, 0]", "position_m"),
    ],
)
def test_a_mistake_names_the_key(tmp_path: Path, figures: str, words: str) -> None:
    with pytest.raises(ValueError, match=f"(?s)imaging_sonars.*{words}"):
        Simulator(pool_with(tmp_path, f"\nimaging_sonars:\n  eye: {{{figures}}}\n"))
