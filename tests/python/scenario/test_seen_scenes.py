"""Lakes are clear, and the pool of the exercises has walls on all sides."""

import math

import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from uwsim import Simulator
from uwsim.scenario import ScenarioError
from uwsim.scenario.spec.optics import Optics

AHEAD_M = 11.7


@pytest.mark.parametrize(("scenario", "least"), [("tarn", 30.0), ("lake", 10.0)])
def test_a_yellow_gate_11_7_m_ahead_is_seen_without_lamps(scenario, least):
    with Simulator(scenario, seed=7) as sim:
        gate = next(each for each in sim.scenario.obstacles if each.name == "gate_main")
        (x, y), half = gate.position_m, math.radians(gate.yaw_deg) / 2
        away_m = AHEAD_M + sim.rov.cameras["front"].mount.position_m[0]
        place = (x - away_m * math.cos(2 * half), y - away_m * math.sin(2 * half))
        z = sim.world.height_at([[x, y]])[0] + 0.5 * gate.height_m
        sim.rov.place((*place, z), (0.0, 0.0, math.sin(half), math.cos(half)))
        frame = sim.rov.cameras["front"].resized(320).capture()
        bars = frame.labels == sim.label_names.index("gate_main")
        around = binary_dilation(bars, iterations=3) & ~bars
        assert np.abs(frame.rgb[bars].mean(axis=0) - frame.rgb[around].mean(axis=0)).max() > least  # of 255


def test_the_training_pool_has_a_wall_in_every_direction():
    with Simulator("training_pool") as sim:
        turns = np.radians(np.arange(0.0, 360.0, 5.0))
        rays = np.column_stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)])
        ranges_m = np.asarray(sim.scene.cast(np.tile([0.0, 0.0, -2.0], (len(rays), 1)), rays, 100.0).ranges_m)
    walls_m = np.minimum(12.5 / np.abs(rays[:, 0]).clip(1e-9), 10.0 / np.abs(rays[:, 1]).clip(1e-9))
    np.testing.assert_allclose(ranges_m, walls_m, atol=0.06)  # targets and lamps stand out by up to 5 cm


def test_a_visibility_that_no_such_water_has_is_refused_before_a_picture() -> None:
    with pytest.raises(ScenarioError, match=r"visibility_m = 0.1 m: impossible in this water: optics.diffuse_atten"):
        Optics(jerlov="III").with_changes({"jerlov": "I", "visibility_m": 0.1})
