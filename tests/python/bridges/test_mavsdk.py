"""MAVSDK's examples, with a submarine's values: telemetry, mission, offboard, manual control.

MAVSDK 4.1 has no modes of submarines: it refuses to change the mode of an ArduSub, real or not, before it sends
anything. Modes are therefore commanded directly, which its MavlinkDirect is for.
"""

import ctypes
import json
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
pytest.importorskip("mavsdk", reason="needs mavsdk of the dependency group dev")
import mavsdk
from mavsdk.plugins.action import Action, ActionError
from mavsdk.plugins.manual_control import ManualControl
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.mission import Mission, MissionError, MissionItem, MissionPlan
from mavsdk.plugins.offboard import Offboard, OffboardError, VelocityBodyYawspeed, VelocityNedYaw
from mavsdk.plugins.telemetry import Telemetry

from mavlink_station import DONE, GUIDED, MANUAL, lagoon, served
from uwsim.bridges.mavlink.modes import AUTO
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Home
from waiting import until

HOME = Home(33.810313, -118.393867)
ANSWER_S = 10.0  # MAVSDK's default is 0.5 s, which a busy machine exceeds; its Python cannot set it


class Drone(NamedTuple):
    """MAVSDK's plugins for one vehicle, which live as long as its client: its threads call them."""

    action: Action
    direct: MavlinkDirect
    manual: ManualControl
    mission: Mission
    offboard: Offboard
    telemetry: Telemetry


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with lagoon() as live:
        live.speed = 10.0
        yield live


@pytest.fixture(scope="module")
def drone(live: LiveSimulator) -> Iterator[Drone]:
    mavsdk.log_subscribe(lambda level, text, file, line: True)
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with served(live) as vehicle, mavsdk.Mavsdk(configuration) as client:
        client._lib.mavsdk_set_timeout_s(ctypes.c_void_p(client._handle), ctypes.c_double(ANSWER_S))
        client.add_any_connection(f"udpout://127.0.0.1:{vehicle.endpoint.port}")
        system = client.first_autopilot(timeout_s=30.0)
        assert system is not None and system.vehicle_type() == mavsdk.Vehicle.SUBMARINE
        yield Drone(
            Action(system),
            MavlinkDirect(system),
            ManualControl(system),
            Mission(system),
            Offboard(system),
            Telemetry(system),
        )


def set_mode(drone: Drone, mode: int) -> None:
    command = {"target_system": 1, "target_component": 1, "command": 176, "confirmation": 0, "param1": 1,
               "param2": mode, **{f"param{k}": 0 for k in range(3, 8)}}  # fmt: skip
    ack = drone.direct.send_command(MavlinkMessage("COMMAND_LONG", 245, 190, 1, 1, json.dumps(command)))
    assert json.loads(ack.fields_json)["result"] == DONE


def arm(drone: Drone) -> None:
    """Arm in MANUAL: in AUTO, which an ArduSub keeps while disarmed, MAVSDK 4.1 crashes, since it changes the mode."""
    set_mode(drone, MANUAL)
    until(lambda: drone.telemetry.flight_mode() == 0)  # unknown to it
    drone.action.arm()


def mission_item(live: LiveSimulator, east: float, north: float, altitude_m: float, **changes: Any) -> Any:
    """Return an item at a place relative to the vehicle's."""
    here = live.rov.pose.position_world_m
    lat, lon = HOME.degrees(here + np.array([east, north, 0.0]))
    values = {"latitude_deg": lat, "longitude_deg": lon, "relative_altitude_m": altitude_m, "speed_m_s": 0.6,
              "is_fly_through": False, "gimbal_pitch_deg": math.nan, "gimbal_yaw_deg": math.nan,
              "camera_action": MissionItem.CameraAction.NONE, "loiter_time_s": math.nan,
              "camera_photo_interval_s": math.nan, "acceptance_radius_m": math.nan, "yaw_deg": math.nan,
              "camera_photo_distance_m": math.nan, "vehicle_action": MissionItem.VehicleAction.NONE}  # fmt: skip
    item = MissionItem()
    for name, value in (values | changes).items():
        setattr(item, name, value)
    return item


def test_telemetry_and_health(live: LiveSimulator, drone: Drone) -> None:
    telemetry = drone.telemetry
    until(telemetry.health_all_ok)
    telemetry.set_rate_odometry(20.0)
    until(lambda: telemetry.odometry().time_usec > 0 and telemetry.gps_info().fix_type == 3)
    assert telemetry.battery().remaining_percent > 90

    def off_m() -> float:
        at = telemetry.position()
        there = HOME.world_m(at.latitude_deg, at.longitude_deg, at.relative_altitude_m)
        return float(np.linalg.norm(there - live.rov.pose.position_world_m))

    until(lambda: off_m() < 0.2)
    assert telemetry.home().latitude_deg == pytest.approx(HOME.lat_deg)
    until(lambda: telemetry.landed_state() == 1)  # docked


def test_a_mission_is_flown_to_its_end(live: LiveSimulator, drone: Drone) -> None:
    """The first item becomes ArduPilot's home, as with every ArduPilot."""
    mission, action = drone.mission, drone.action
    items = [mission_item(live, 0, 0, 0.0), mission_item(live, 0, 1.5, -2.5),
             mission_item(live, 0, 4.0, -3.0, loiter_time_s=1.0)]  # fmt: skip
    goal = live.rov.pose.position_world_m + np.array([0.0, 4.0, 0.0])
    mission.upload_mission(MissionPlan(items))
    assert [item.relative_altitude_m for item in mission.download_mission().mission_items] == [0.0, -2.5, -3.0]
    arm(drone)
    seen: list[int] = []
    following = mission.subscribe_mission_progress(lambda progress, data=None: seen.append(progress.current))
    set_mode(drone, AUTO)
    until(lambda: mission.is_mission_finished() and 3 in seen)
    mission.unsubscribe_mission_progress(following)
    assert seen == sorted(seen) and {1, 2} <= set(seen)
    assert np.hypot(*(live.rov.pose.position_world_m - goal)[:2]) < 0.7
    action.disarm()


def test_what_a_submarine_cannot_do_is_refused(live: LiveSimulator, drone: Drone) -> None:
    action, mission = drone.action, drone.mission
    with pytest.raises(ActionError):
        action.takeoff()
    mission.upload_mission(MissionPlan([mission_item(live, 0, 0, 0.0)] * 3))
    with pytest.raises(MissionError):
        mission.upload_mission(MissionPlan([mission_item(live, 0, 0, 0.0), mission_item(live, 1, 0, 10.0)]))
    assert len(mission.download_mission().mission_items) == 3, "the old one stays"


def test_offboard_velocities_steer_until_they_end(live: LiveSimulator, drone: Drone) -> None:
    action, offboard = drone.action, drone.offboard
    arm(drone)
    set_mode(drone, GUIDED)

    def moves(ahead: float, north: float) -> bool:
        velocity = live.rov.velocity.linear_body_m_s
        world = live.rov.pose.world_from_body[:3, :3] @ velocity
        return bool(abs(velocity[0] - ahead) < 0.06 if north == 0 else abs(world[1] - north) < 0.06)

    offboard.set_velocity_body(VelocityBodyYawspeed(0.3, 0.0, 0.0, 0.0))
    until(lambda: moves(0.3, 0.0))
    offboard.set_velocity_ned(VelocityNedYaw(-0.3, 0.0, 0.0, 90.0))
    until(lambda: moves(0.0, -0.3))
    with pytest.raises(OffboardError):
        offboard.stop()  # the mode cannot be changed, but the setpoints end
    until(lambda: bool(np.linalg.norm(live.rov.velocity.linear_body_m_s) < 0.05))
    action.disarm()


def test_manual_control_moves_it(live: LiveSimulator, drone: Drone) -> None:
    action, manual = drone.action, drone.manual
    arm(drone)

    def moves() -> bool:
        manual.set_manual_control_input(1.0, 0.0, 0.5, 0.0)
        return bool(live.rov.effort[0] == pytest.approx(0.5))  # ArduSub's gain

    until(moves)
    action.disarm()
    until(lambda: not np.any(live.rov.effort))
