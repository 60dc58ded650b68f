"""Missions find the altimeter and the sensor to port by kind and mount, whatever their names."""

from pathlib import Path

import pytest

import uwsim
from uwsim.missions import goto
from uwsim.missions.planners.area_missions import unknown_water
from uwsim.navigation.sensor_choice import altimeter, height_above_bed_m, port_proximity
from uwsim.scenario.read.assets import find_yaml

OTHER_NAMES = (
    "{builds_on: rov, sensors: {altitude: null, proximity_port: null, sounder: {kind: altitude},"
    " aside: {kind: proximity, position_m: [0, 0.4, 0], yaw_pitch_roll_deg: [80, 0, 0], range_max_m: 10}}}"
)


@pytest.fixture
def pool(tmp_path: Path) -> Path:
    path = tmp_path / "pool.yaml"
    path.write_text(find_yaml("pool", "scenarios").read_text().replace("model: rov", f"model: {OTHER_NAMES}"))
    return path


def test_they_are_chosen_by_kind_and_direction(pool: Path) -> None:
    with uwsim.Simulator(pool) as sim, uwsim.Simulator("pool") as packaged:
        sensors = sim.rov.sensors
        assert altimeter(sensors) is sensors["sounder"] and port_proximity(sensors) is sensors["aside"]
        assert altimeter(packaged.rov.sensors) is packaged.rov.sensors["altitude"]
        assert port_proximity(packaged.rov.sensors) is packaged.rov.sensors["proximity_port"]
        assert height_above_bed_m(sim.rov) == pytest.approx(sensors["sounder"].read())
        assert port_proximity({}) is None
    with pytest.raises(ValueError, match="no sensor of kind 'altitude'"):
        height_above_bed_m(type("Blind", (), {"sensors": {}}))


def test_moves_and_planners_fly_with_them(pool: Path) -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-2.0, 1.0), altitude_m=2.5)
        assert height_above_bed_m(vehicle) == pytest.approx(2.5, abs=0.3)
        yield from unknown_water(vehicle, bound_m=7.0, altitude_m=2.0)

    flown = uwsim.fly(mission, pool, time_limit_s=60.0)
    assert flown.ended_because == "the time limit is reached" or not flown.ended_early
    assert flown.collisions == 0
