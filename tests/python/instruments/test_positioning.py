"""A GPS that dives, and an INS that drifts: the same after a resume, and on the wires."""

import math
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pyproj
import pytest

from channel_tools import table
from uwsim import Simulator
from uwsim.bridges.nmea.readings import read as sentences
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.sensor import GRADES, SensorMount

LATITUDE_DEG, LONGITUDE_DEG = 43.1, 5.9
SENSORS: dict[str, Any] = {
    "imu": {"kind": "imu", "rate_hz": 50},
    "gps": {"kind": "gps", "rate_hz": 5, "channels": {"horizontal": {"std": 2.1}}},
    "ins": {"kind": "ins", "rate_hz": 10, "grade": "tactical"},
    "adcp": {"kind": "adcp", "rate_hz": 2},
}


@pytest.fixture
def sim() -> Simulator:
    earth = {"latitude_deg": LATITUDE_DEG, "longitude_deg": LONGITUDE_DEG}
    scenario = validated(Scenario, {**load("lagoon").given(), "earth": earth})
    sensors = {name: SensorMount.model_validate(mount) for name, mount in SENSORS.items()}
    entry = scenario.vehicles[0]
    entry = entry.model_copy(update={"model": entry.model.model_copy(update={"sensors": sensors})})
    return Simulator(scenario.model_copy(update={"vehicles": (entry,)}), seed=4)


def hover(sim: Simulator, height_m: float, seconds: float) -> None:
    for _ in range(round(10 * seconds)):
        sim.rov.place((-20.0, -18.0, height_m))
        sim.advance(0.1)


def test_a_resumed_run_has_the_same_fixes_and_the_same_drift(sim):
    def readings() -> np.ndarray:
        """Return what the sensors read in the next 5 s, out of the water."""
        found = []
        for _ in range(50):
            hover(sim, 0.5, 0.1)
            found += [np.ravel(each) for name in SENSORS for each in sim.rov.sensors[name].read().to_dict().values()]
        return np.concatenate(found)

    for height_m, seconds in ((0.5, 1.0), (-3.0, 2.0), (0.5, 0.4)):  # up to the middle of the reacquisition
        hover(sim, height_m, seconds)
    state, straight = sim.save_state(), readings()
    sim.restore_state(state)
    np.testing.assert_array_equal(readings(), straight)
    assert sim.rov.sensors["gps"].sample().valid


def test_ros_and_nmea_have_no_fix_under_water_and_pyprojs_degrees_in_the_air(sim):
    def gga() -> list[str]:
        lines = sentences(sim.rov, georeference(sim.scenario), lambda at: datetime.fromtimestamp(at, UTC), sim.time_s)
        return next(line for line in lines if line[3:6] == "GGA").split(",")

    hover(sim, -3.0, 0.5)
    message = table(sim)["gps"].read(sim)
    assert message.status.status == -1 and math.isnan(message.latitude)
    assert gga()[6] == "0" and gga()[2] == ""
    hover(sim, 0.5, 1.5)
    assert gga()[6] == "1" and float(gga()[2]) == pytest.approx(100 * 43 + 60 * 0.1, abs=0.05)
    message = table(sim)["gps"].read(sim)
    geod = pyproj.Geod(ellps="WGS84")
    azimuth, _, away_m = geod.inv(LONGITUDE_DEG, LATITUDE_DEG, message.longitude, message.latitude)
    east, north = sim.rov.sensors["gps"].read().position_m[:2]
    expected = (math.hypot(east, north), math.atan2(east, north))
    assert message.status.status == 0
    assert (away_m, math.radians(azimuth)) == pytest.approx(expected, abs=1e-3)
    assert message.position_covariance[0] == pytest.approx(2.1**2) and message.position_covariance_type == 2


def test_an_ins_is_published_as_odometry_in_its_own_frame(sim):
    hover(sim, -3.0, 1.0)
    message, read = table(sim)["ins/odometry"].read(sim), sim.rov.sensors["ins"].read()
    position = message.pose.pose.position
    assert message.child_frame_id == "ins_link"
    assert (position.x, position.y) == pytest.approx(tuple(read.position_m[:2]))
    assert table(sim)["adcp"].read(sim).velocity_mode == 2


def test_grades_are_of_an_ins_alone_and_written_parameters_stand_above_them():
    mount = SensorMount.model_validate({"kind": "ins", "grade": "mems", "gyro_bias_deg_h": 10})
    assert mount.parameters["gyro_bias_deg_h"] == (10.0,)
    assert mount.parameters["accelerometer_bias_ug"] == (GRADES["ins"]["mems"]["accelerometer_bias_ug"],)
    for kind, grade, rule in (("ins", "gold", "navigation, tactical, mems"), ("imu", "mems", "'imu' has no grades")):
        with pytest.raises(ScenarioError, match=rule):
            validated(SensorMount, {"kind": kind, "grade": grade})
