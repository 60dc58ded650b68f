"""A mission's items: each is flown as uploaded, or refused with its number and MAVLink's result."""

import math
from collections import deque
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim import Simulator
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.fence import FenceKeeper
from uwsim.bridges.mavlink.missions import MissionStore
from uwsim.bridges.mavlink.plan import MissionPlan
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.state import read
from uwsim.bridges.mavlink.telemetry import KINDS, Figures
from uwsim.bridges.mavlink.vehicle import MavlinkVehicle
from uwsim.channels import Table
from uwsim.mapping.files.georeference import Home
from uwsim.missions import OwnVehicle, drive
from uwsim.missions.items import RefusedItemError, checked
from uwsim.missions.pictures import PictureFolder

HOME = Home(33.810313, -118.393867)
NAN = math.nan
TEXTS: list[str] = []


def item(
    number: int, command: int, *values: float, at: tuple[float, float, float] | None = None, frame: int = 6
) -> Any:
    """Return an item. values: its parameters. at: metres east, north and up of the world's origin."""
    lat, lon = HOME.degrees(np.array(at)) if at else (0.0, 0.0)
    parameters = [*values, *[0.0] * (4 - len(values))]
    place = round(1e7 * lat), round(1e7 * lon), at[2] if at else 0.0
    return dialect.MAVLink_mission_item_int_message(1, 1, number, frame, command, 0, 1, *parameters, *place)


class Servos(NamedTuple):
    """Outputs that keep the pulses that are set."""

    pulses: dict[int, float]

    def set(self, output: int, pulse_us: float) -> None:
        self.pulses[output] = pulse_us

    def refusal(self, output: float, pulse_us: float) -> tuple[int, str] | None:
        return None if output == 13 else (1, "13")


def craft_of(sim: Simulator) -> Any:
    launch = sim.rov.pose.position_world_m * [1, 1, 0]
    return SimpleNamespace(home=HOME, vehicle=sim.rov, launch_world_m=launch, send_text=TEXTS.append, pictures=None)


@pytest.fixture(scope="module")
def sim() -> Any:
    with Simulator("lagoon", seed=3) as sim:
        sim.rov.undock()
        yield sim


class Flown(NamedTuple):
    """The track of a flight: time [s], position (n, 3), yaw [rad], and the times at which each item began and ended."""

    times: np.ndarray
    points: np.ndarray
    yaws: np.ndarray
    began: dict[int, float]
    ended: dict[int, float]
    pulses: dict[int, float]

    def during(self, number: int) -> np.ndarray:
        return (self.times >= self.began[number]) & (self.times <= self.ended[number])


def fly(sim: Simulator, *items: Any, first: int = 1) -> Flown:
    servos, began, ended, rows = Servos({}), {}, {}, []
    craft = craft_of(sim)
    whole = [item(0, 16), *(checked(each, craft, servos) for each in items)]
    plan = MissionPlan(
        whole, first, craft, servos,
        lambda number: began.update({number: sim.time_s}), lambda number: ended.update({number: sim.time_s}),
    )  # fmt: skip
    vehicle = OwnVehicle(sim.rov, sim)

    def watched() -> Any:
        for each in plan.steps(vehicle, lambda leg: None):
            rows.append((sim.time_s, *vehicle.pose.position_world_m, vehicle.pose.yaw_rad))
            yield each

    drive(watched(), sim)
    assert list(ended) == [each.seq for each in items if each.seq >= first] == list(began)
    table = np.array(rows)
    return Flown(table[:, 0], table[:, 1:4], np.unwrap(table[:, 4]), began, ended, servos.pulses)


def test_each_leg_is_flown_at_its_speed_and_each_hold_lasts(sim: Simulator) -> None:
    start = np.array([-14.0, -18.0, -3.0])
    ends = [start + np.array([0, 6, 0]), start + np.array([0, 12, -1])]
    flown = fly(
        sim, item(1, 16, at=tuple(start)), item(2, 178, 1, 0.3, -1), item(3, 16, 4.0, at=tuple(ends[0])),
        item(4, 178, 1, 0.6, -1), item(5, 16, at=tuple(ends[1])), item(6, 93, 3.0, -1, -1, -1), item(7, 183, 13, 1900),
    )  # fmt: skip
    for number, speed, end in ((3, 0.3, ends[0]), (5, 0.6, ends[1])):
        on = flown.during(number)
        gone = np.linalg.norm(flown.points[on][:, :2] - (end - [0, 6, 0])[:2], axis=1)
        mid = (gone > 2) & (gone < 5)
        speeds = np.gradient(gone[mid], flown.times[on][mid])
        assert speeds.mean() == pytest.approx(speed, rel=0.1)
        assert np.linalg.norm(flown.points[on] - end, axis=1).min() < 0.5
    near = np.linalg.norm(flown.points - ends[0], axis=1) < 0.5
    assert np.ptp(flown.times[near & flown.during(3)]) >= 4.0
    assert flown.ended[6] - flown.began[6] == pytest.approx(3.0, abs=0.11)
    assert flown.pulses == {13: 1900}


def test_circles_and_turns_go_the_stated_way(sim: Simulator) -> None:
    flown = fly(
        sim, item(1, 178, 1, 0.5), item(2, 18, 1, 0, 3.0, at=(-10.0, -10.0, -3.0)), item(3, 115, 90, 30, 0, 0),
        item(4, 115, 200, 60, 1, 1), item(5, 19, 2.0, at=(0.0, 0.0, -3.0)), first=2,
    )  # fmt: skip
    offset = flown.points[flown.during(2)][:, :2] - [-10.0, -10.0]
    radius, angle = np.hypot(*offset.T), np.unwrap(np.arctan2(offset[:, 1], offset[:, 0]))
    on_it = abs(radius - 3.0) < 0.5
    assert np.ptp(angle[on_it]) == pytest.approx(math.tau, abs=0.5) and angle[on_it][-1] < angle[on_it][0]
    yaw = flown.yaws[flown.during(3)]
    assert math.remainder(yaw[-1], math.tau) == pytest.approx(0.0, abs=0.06), "90 deg from north is east"
    yaw = flown.yaws[flown.during(4)]
    assert yaw[-1] - yaw[0] == pytest.approx(-math.radians(200), abs=0.1)
    assert flown.ended[5] - flown.began[5] >= 2.0


def test_a_waypoint_above_the_bed_is_there_and_triggers_and_jumps_end_no_survey(sim: Simulator) -> None:
    x, y, _ = sim.rov.pose.position_world_m
    ends = [(x + 4, y, 1.5), (x, y, 1.5)]
    flown = fly(
        sim, item(1, 16, at=ends[0], frame=10), item(2, 206, 5.0), item(3, 82, 1.0, at=ends[1], frame=11),
        item(4, 177, 1, 2), item(5, 22, NAN, at=(x, y, 3.0)), item(6, 211, 1, 1),
    )  # fmt: skip
    assert {"mission item 5: take-off: has no effect", "mission item 6: gripper: has no effect"} <= {*TEXTS}
    assert "mission item 2: camera trigger by distance: has no effect" in TEXTS
    assert "mission item 3: spline: is flown straight" in TEXTS
    bed_m = sim.world.height_at(flown.points[:, :2])
    on = flown.during(3)
    assert (flown.points[on][-1, 2] - bed_m[on][-1]) == pytest.approx(1.5, abs=0.2)
    far = flown.points[:, 0] > x + 3.5
    assert np.count_nonzero(np.diff(far.astype(int)) == 1) == 3, "there and twice more"


def test_a_picture_is_a_file_and_a_message_with_its_place(sim: Simulator, tmp_path: Path) -> None:
    owner: Any = SimpleNamespace(
        _craft=SimpleNamespace(output=Waiting(10)), _autopilot=SimpleNamespace(mav=dialect.MAVLink(None))
    )
    MavlinkVehicle._picture_taker(owner, PictureFolder(tmp_path, HOME))(OwnVehicle(sim.rov, sim), 4)
    (message,) = owner._craft.output.taken()
    assert message.pack(dialect.MAVLink(None)) and (tmp_path / message.file_url).stat().st_size > 1000
    at = HOME.world_m(1e-7 * message.lat, 1e-7 * message.lon, 1e-3 * message.alt)
    np.testing.assert_allclose(at, sim.rov.pose.position_world_m, atol=0.02)
    assert (message.image_index, message.capture_result) == (0, 1)
    PictureFolder(tmp_path, HOME).take(OwnVehicle(sim.rov, sim), 5)  # of another flight
    table = (tmp_path / "pictures.csv").read_text().splitlines()
    assert [row.partition(",")[0] for row in table] == ["file", "rov-chase-00000.png", "rov-chase-00001.png"]
    (tmp_path / "pictures.csv").write_text("mine")
    with pytest.raises(FileExistsError, match="uwsim did not write it"):
        PictureFolder(tmp_path, HOME)


def test_what_is_below_the_bed_is_flown_above_it_and_named(sim: Simulator) -> None:
    """ArduSub does not know the bed, and takes items at or below it, as those of its own suite's DiveMission are."""
    TEXTS.clear()
    flown = fly(
        sim, item(1, 178, 1, 0.5), item(2, 16, at=(-8.0, -8.0, -50.0)), item(3, 18, 0.2, 0, 3.0, at=(0.0, -8.0, -50.0)),
        item(4, 21, at=(0.0, 0.0, -50.0)), first=2,
    )  # fmt: skip
    assert len(TEXTS) == 2 and "item 2: altitude = -50 m: is below the bed, whose height there is" in TEXTS[0]
    for number in (2, 3):
        x, y, z = flown.points[flown.during(number)][-1]
        assert z - sim.world.height_at([[x, y]])[0] == pytest.approx(1.0, abs=0.5)


def keeper_of(texts: list[str]) -> FenceKeeper:
    return FenceKeeper(
        SimpleNamespace(home=HOME, state=None, send_text=lambda text, *_: texts.append(text)),  # type: ignore[arg-type]
        Settings(),
    )


def at_m(number: int, command: int, x: float, y: float, param1: float = 0.0) -> Any:
    return item(number, command, param1, at=(x, y, -2.0))


SQUARE = [at_m(k, 5001, x, y, 4) for k, (x, y) in enumerate([(0, 0), (20, 0), (20, 20), (0, 20)])]
ROCK = at_m(4, 5004, 10.0, 10.0, 2.0)


def test_a_mission_that_leaves_the_fence_is_refused_and_so_is_auto_if_the_fence_came_later() -> None:
    texts: list[str] = []
    keeper = keeper_of(texts)
    store = MissionStore(dialect.MAVLink(None), lambda *_: None, lambda t, *_: texts.append(t), deque(), id, keeper)
    store._accept(0, [at_m(0, 16, 0, 0), at_m(1, 16, 2, 10), at_m(2, 16, 18, 10)])
    store._accept(1, [*SQUARE, ROCK])
    assert texts[0] == "geofence: 2 zones: missions that leave it are refused"
    assert texts[1].startswith("mission item 2: the leg from (2.0, 10.0) to (18.0, 10.0) m enters zone 2 of the fence")
    with pytest.raises(ValueError, match="a circle of 2 m to stay out of"):
        store.require_within_fence()
    with pytest.raises(ValueError, match=r"mission item 1: \(25.0, 1.0\) m leaves zone 1"):
        store._accept(0, [at_m(0, 16, 0, 0), at_m(1, 16, 25, 1)])
    store._accept(0, [at_m(0, 16, 0, 0), at_m(1, 16, 2, 2), at_m(2, 16, 18, 2)])
    store.require_within_fence()
    keeper._settings.set("FENCE_ENABLE", 0)
    store._accept(0, [at_m(0, 16, 0, 0), at_m(1, 16, 25, 1)])
    for wrong, words in [
        ([SQUARE[0], ROCK], "4: the polygon before it lacks"),
        ([at_m(0, 5003, 0, 0)], "radius = 0 m"),
        (SQUARE[:3], "has 3 corners"),
        ([at_m(0, 5001, 0, 0, 2)], "2 corners: must be"),
    ]:
        with pytest.raises(ValueError, match=words):
            store._accept(1, wrong)


def test_a_breach_is_reported_once_and_holds_only_if_fence_action_says_so() -> None:
    texts: list[str] = []
    keeper = keeper_of(texts)
    keeper.keep(SQUARE)

    def at(x: float, *, armed: bool = True) -> bool:
        keeper._craft.state = SimpleNamespace(position_world_m=np.array([x, 5.0, -2.0]), time_s=x)  # type: ignore[assignment]
        return keeper.watch(is_armed=armed)

    assert not any(map(at, (5.0, 25.0))) and keeper._craft.fence == (True, False, False)
    assert not any(map(at, (26.0, 5.0))) and not at(25.0, armed=False) and keeper._craft.fence == (True, False, True)
    breach = (
        "Fence breached: the vehicle at (25.0, 5.0) m leaves zone 1 of the fence, a polygon with 4 corners to stay in"
    )
    assert texts == [f"{breach}: reported only", "Fence breach cleared"]
    keeper._settings.set("FENCE_ACTION", 2)
    assert at(25.0) and not at(26.0) and texts[-1] == f"{breach}: the vehicle is held"
    (status,) = keeper._status(dialect.MAVLink(None))
    assert (status.breach_status, status.breach_count, status.breach_time) == (1, 2, 25000)
    assert status.breach_type == dialect.FENCE_BREACH_BOUNDARY
    assert keeper._craft.fence == (True, True, False)
    keeper.keep([])
    assert not keeper._status(dialect.MAVLink(None)) and not at(27.0) and keeper._craft.fence == (False, False, True)


def test_fences_and_rally_points_are_kept_beside_the_mission_and_given_back() -> None:
    sent: list[Any] = []
    texts: list[str] = []
    store = MissionStore(
        dialect.MAVLink(None),
        lambda m, peer: sent.append(m),
        lambda text, *_: texts.append(text),
        deque(),
        lambda i: i,
        keeper_of(texts),
    )
    peer: Any = object()

    def given(message: Any) -> Any:
        message._header.srcSystem, message._header.srcComponent = 255, 190
        return message

    corners = [(5001, 3, 541000000, 101000000), (5001, 3, 541000000, 101100000), (5001, 3, 541100000, 101000000)]
    fence = [
        dialect.MAVLink_mission_item_int_message(1, 1, k, 0, command, 0, 1, count, 0, 0, 0, x, y, 0.0, 1)
        for k, (command, count, x, y) in enumerate(corners)
    ]
    store.on_mission_count(peer, given(dialect.MAVLink_mission_count_message(1, 1, 3, 1)))
    for each in fence:
        assert (sent[-1].seq, sent[-1].mission_type) == (each.seq, 1)
        store.on_mission_item_int(peer, given(each))
    assert (sent[-1].type, sent[-1].mission_type) == (dialect.MAV_MISSION_ACCEPTED, 1)
    assert texts == ["geofence: 1 zone: missions that leave it are refused"] and store.items == []
    store.on_mission_request_list(peer, given(dialect.MAVLink_mission_request_list_message(1, 1, 1)))
    assert sent[-1].count == 3
    for k, each in enumerate(fence):
        store.on_mission_request_int(peer, given(dialect.MAVLink_mission_request_int_message(1, 1, k, 1)))
        assert (sent[-1].command, sent[-1].x, sent[-1].y, sent[-1].mission_type) == (each.command, each.x, each.y, 1)
    store.on_mission_count(peer, given(dialect.MAVLink_mission_count_message(1, 1, 1, 2)))
    wrong = dialect.MAVLink_mission_item_int_message(1, 1, 0, 0, 5001, 0, 1, 3, 0, 0, 0, 1, 1, 0.0, 2)
    store.on_mission_item_int(peer, given(wrong))
    assert sent[-1].type == dialect.MAV_MISSION_UNSUPPORTED and "rally points: command 5001" in texts[-1]
    store.on_mission_clear_all(peer, given(dialect.MAVLink_mission_clear_all_message(1, 1, 255)))
    store.on_mission_request_list(peer, given(dialect.MAVLink_mission_request_list_message(1, 1, 1)))
    assert sent[-1].count == 0


def test_land_and_return_end_at_the_surface(sim: Simulator) -> None:
    home = sim.rov.pose.position_world_m.copy()
    flown = fly(sim, item(1, 16, at=(home[0] + 3, home[1], -2.0)), item(2, 20, NAN, NAN, NAN, NAN))
    assert np.hypot(*(flown.points[-1] - home)[:2]) < 0.7 and flown.points[-1, 2] > -0.3
    landed = fly(sim, item(1, 16, at=(home[0], home[1] + 3, -2.0)), item(2, 21))
    assert np.hypot(*(landed.points[-1] - home - [0, 3, 0])[:2]) < 0.7 and landed.points[-1, 2] > -0.3


@pytest.mark.parametrize(
    ("wrong", "result", "words"),
    [
        (item(4, 31, at=(0, 0, -1)), dialect.MAV_MISSION_UNSUPPORTED, "command 31: must be waypoint (16)"),
        (item(4, 16, -1.0, at=(0, 0, -1)), dialect.MAV_MISSION_INVALID_PARAM1, "hold = -1 s"),
        (item(4, 16, NAN, at=(0, 0, -1)), dialect.MAV_MISSION_INVALID_PARAM1, "hold = nan s"),
        (item(4, 16, at=(0, 0, 1)), dialect.MAV_MISSION_INVALID_PARAM7, "altitude = 1 m"),
        (item(4, 16, at=(500, 0, -1)), dialect.MAV_MISSION_INVALID_PARAM5_X, "must be above the terrain"),
        (item(4, 16, at=(0, 0, -1), frame=1), dialect.MAV_MISSION_UNSUPPORTED_FRAME, "frame 1"),
        (item(4, 16, at=(0, 0, -1), frame=10), dialect.MAV_MISSION_INVALID_PARAM7, "height = -1 m above the bed"),
        (item(4, 21, at=(0, 0, 1), frame=10), dialect.MAV_MISSION_UNSUPPORTED_FRAME, "is for waypoints"),
        (item(4, 177, 0, 1), dialect.MAV_MISSION_INVALID_PARAM1, "jump to item 0"),
        (item(4, 18, 1, 0, 0.1, at=(0, 0, -1)), dialect.MAV_MISSION_INVALID_PARAM3, "radius = 0.1 m"),
        (item(4, 93, -1, 12, 0, 0), dialect.MAV_MISSION_INVALID_PARAM1, "delay = -1 s"),
        (item(4, 115, 90, 0, 0.5), dialect.MAV_MISSION_INVALID_PARAM3, "direction = 0.5"),
        (item(4, 178, 2, 1.0), dialect.MAV_MISSION_INVALID_PARAM1, "type = 2"),
        (item(4, 178, 1, NAN), dialect.MAV_MISSION_INVALID_PARAM2, "speed = nan m/s"),
        (item(4, 183, 1, 1500), dialect.MAV_MISSION_INVALID_PARAM1, "servo param1"),
    ],
)
def test_an_item_that_cannot_be_flown_is_refused(sim: Simulator, wrong: Any, result: int, words: str) -> None:
    with pytest.raises(RefusedItemError, match=r"^mission item 4: ") as caught:
        checked(wrong, craft_of(sim), Servos({}))
    assert caught.value.result == result and words in str(caught.value)


POWERED = """
name: powered
mission_time_s: 60
terrain: {source: noise, size_m: [400, 400], spacing_m: 20, bed_depth_m: 60}
vehicles:
  - {name: rov, model: bluerov2_heavy, start: {position_m: [0, 0, -20]}, battery: {model: bluerov2_18ah, hotel_w: 40}}
"""


def test_volts_and_amperes_are_the_packs(tmp_path: Path) -> None:
    """At the terminals, and the charge that has left, in mAh."""
    (tmp_path / "powered.yaml").write_text(POWERED)
    with Simulator(tmp_path / "powered.yaml") as sim:
        sim.rov.set_effort(surge=0.5)
        sim.advance(20.0)
        pack, state = sim.rov.battery, read(sim, Table(sim).sources[0], truth=True)
        figures = Figures(state, Craft(None, "rov", None, HOME, lambda text, severity=4, /: None))  # type: ignore
        made = (kind.make(dialect.MAVLink(None), figures) for kind in KINDS if kind.number in (1, 147))
        found = {message.get_type(): message for messages in made for message in messages}
    assert found["SYS_STATUS"].voltage_battery == found["BATTERY_STATUS"].voltages[0] == round(1e3 * pack.voltage_v)
    assert found["SYS_STATUS"].current_battery == found["BATTERY_STATUS"].current_battery == round(100 * pack.current_a)
    assert found["BATTERY_STATUS"].current_consumed == round(1e3 * (pack.capacity_ah - pack.charge_ah)) > 0
    assert 10 < pack.voltage_v < 17 and pack.current_a > 1
