"""Missions as generators: time passes at each yield, steps compose, and repeated flights are identical bit for bit."""

import math
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.live import LiveSimulator
from uwsim.missions import (
    LawnMowerPlan,
    OwnVehicle,
    StoppedError,
    dive_to,
    drive,
    follow,
    goto,
    hold,
    parallel,
    race,
    run,
    turn_to,
    until,
    wait,
)
from uwsim.missions.own_vehicle import TiltWarning


class Clock:
    def __init__(self) -> None:
        self.time_s = 0.0

    def wait(self, duration_s: float) -> None:
        self.time_s = round(self.time_s + duration_s, 9)


def test_time_passes_only_where_a_mission_yields_and_until_its_condition_or_its_time() -> None:
    clock, times = Clock(), []

    def steps():
        times.append(clock.time_s)
        yield wait(0.5)
        times.append(clock.time_s)
        yield from wait(0.25)  # equivalent form
        times.append(clock.time_s)
        return "done"

    assert drive(steps(), clock) == "done"
    assert times == [0.0, 0.5, 0.75]
    assert drive(until(lambda: clock.time_s >= 1.75), clock) is True
    assert clock.time_s == pytest.approx(1.75)
    assert drive(until(lambda: False, timeout_s=2.0), clock) is False
    assert clock.time_s == pytest.approx(3.75)


def ticking(clock: Clock, name: str, period_s: float, times: int, log: list) -> object:
    for _ in range(times):
        yield wait(period_s)
        log.append((clock.time_s, name))
    return name


def test_branches_run_at_their_own_times_and_in_the_order_of_the_arguments_at_one_time() -> None:
    clock, log = Clock(), []
    both = parallel(ticking(clock, "a", 0.2, 3, log), ticking(clock, "b", 0.3, 2, log))
    assert drive(both, clock) == ["a", "b"]
    assert log == [(0.2, "a"), (0.3, "b"), (0.4, "a"), (0.6, "a"), (0.6, "b")]


def test_the_first_branch_to_end_wins_or_its_error_does_and_the_others_are_closed() -> None:
    clock, closed = Clock(), []

    def slow():
        try:
            yield wait(10.0)
        finally:
            closed.append(clock.time_s)

    def failing():
        yield wait(1.0)
        raise ValueError("broken")

    assert drive(race(slow(), ticking(clock, "b", 1.0, 2, [])), clock) == (1, "b")
    assert closed == [2.0]
    assert clock.time_s == 2.0
    with pytest.raises(ValueError, match="broken"):
        drive(parallel(slow(), failing()), clock)
    assert closed == [2.0, 3.0]


@pytest.mark.parametrize(
    ("yielded", "words"),
    [
        (lambda: ticking(Clock(), "", 1.0, 1, []), "yield from ticking"),
        (lambda: 0.1, "yield wait"),
        (lambda: None, "yield wait"),
    ],
)
def test_what_is_no_wait_is_refused_with_what_to_write(yielded, words: str) -> None:
    def steps():
        yield yielded()

    with pytest.raises(TypeError, match=words):
        drive(steps(), Clock())
    for duration_s in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="must be positive"):
            wait(duration_s)


def test_a_simulator_rounds_waits_to_whole_steps() -> None:
    sim = Simulator("pool")

    def mission(vehicle):
        for duration_s in (0.1, 0.0333, 0.001):
            yield wait(duration_s)
            vehicle.log("waited")

    events = []
    run(mission, sim.rov, sim, hear=events.append)
    assert [event.time_s for event in events] == pytest.approx([0.1, 0.135, 0.14])


def test_a_mission_must_be_a_generator_of_one_argument() -> None:
    vehicle = SimpleNamespace(name="rov")

    def without_yield(vehicle):
        return 1

    def of_two(vehicle, depth_m):
        yield wait(1.0)

    with pytest.raises(ValueError, match="without_yield: has no `yield`"):
        run(without_yield, vehicle, Clock())
    with pytest.raises(ValueError, match="must take one argument"):
        run(of_two, vehicle, Clock())


def tour(vehicle):
    """A mission with every kind of move."""
    vehicle.undock()
    vehicle.log("undocked", position_m=vehicle.pose.position_world_m)
    yield from dive_to(vehicle, 3.0)
    yield from turn_to(vehicle, 1.0)
    turned = vehicle.pose.yaw_rad
    yield from goto(vehicle, (0.0, 3.0, -2.5), speed_m_s=0.5, within_m=0.3)
    there = vehicle.pose.position_world_m
    yield from hold(vehicle, 20.0, position_world_m=(0.0, 3.0, -2.5))
    held = vehicle.pose.position_world_m
    yield from follow(vehicle, [(0.0, 3.0), (-3.0, 3.0), (-3.0, -3.0)], altitude_m=1.5)
    return turned, there, held, vehicle.sensors["altitude"].read()


def test_a_vehicle_gets_where_the_moves_send_it_and_live_to_the_same_bits() -> None:
    sim, events = Simulator("pool"), []
    turned, there, held, altitude_m = run(tour, sim.rov, sim, hear=events.append)
    assert turned == pytest.approx(1.0, abs=math.radians(4.0))
    assert np.linalg.norm(there - [0.0, 3.0, -2.5]) <= 0.3
    assert np.linalg.norm(held - [0.0, 3.0, -2.5]) < 0.1
    assert altitude_m == pytest.approx(1.5, abs=0.3)
    assert sim.rov.pose.position_world_m[:2] == pytest.approx([-3.0, -3.0], abs=0.5)
    assert sim.rov.collisions == 0
    assert [event.name for event in events] == ["undocked"]
    assert len(events[0].values["position_m"]) == 3
    with LiveSimulator("pool", speed="max", paused=True) as live, live.mission_clock() as clock:
        live.resume()
        run(tour, live.rov, clock)
        live.pause()
        assert live.simulator.save_state() == sim.save_state()


def test_a_way_that_is_blocked_ends_the_mission() -> None:
    sim = Simulator("pool")
    sim.rov.release()
    sim.rov.place([0.0, 6.0, -3.0])

    def into_the_box(vehicle):
        yield from goto(vehicle, (3.0, 0.0, -4.5), within_m=0.1)  # the centre of the box

    with pytest.raises(StoppedError, match=r"stuck .* m before \(3.0, 0.0, -4.5\) m"):
        run(into_the_box, sim.rov, sim)


@pytest.mark.parametrize("offset_m", [(0.4, 0.0, 0.0), (0.0, -0.3, 0.2)])
def test_goto_goes_to_a_target_nearby_and_hold_keeps_it(offset_m) -> None:
    """Within the tolerance at the end of goto, and then at the target itself: the water is still."""
    sim = Simulator("pool")
    sim.rov.undock()
    target_m, left_m = sim.rov.pose.position_world_m + offset_m, []

    def mission(vehicle):
        yield from goto(vehicle, target_m)
        left_m.append(math.dist(vehicle.pose.position_world_m, target_m))
        yield from hold(vehicle, 10.0, position_world_m=target_m)
        left_m.append(math.dist(vehicle.pose.position_world_m, target_m))
        vehicle.set_effort(surge=1.0)
        yield wait(2.0)  # the vehicle is still moving
        began_m = vehicle.pose.position_world_m
        for _ in range(60):
            yield from hold(vehicle, 0.5)
        left_m.append(math.dist(vehicle.pose.position_world_m, began_m))

    run(mission, sim.rov, sim)
    assert 0.0 < left_m[0] <= 0.1 and left_m[1] < 0.01
    assert left_m[2] < 0.15, "repeated holds keep the place of the first"


def test_a_drift_of_centimetres_is_no_part_of_a_vertical_way(monkeypatch) -> None:
    """The depth on the way follows the share of it that is left: 0.06 m aside is not all of a way of 0.05 m."""
    sim = Simulator("pool")
    sim.rov.release()
    wanted_z_m = []
    sim.rov.place([0.0, 0.0, -2.0])
    vehicle = OwnVehicle(sim.rov, sim)

    def steer(vehicle, heading_rad, velocity_m_s, z_m):
        wanted_z_m.append(z_m)
        yield wait(0.1)

    monkeypatch.setattr("uwsim.missions.moves.steer", steer)
    way = goto(vehicle, (0.05, 0.0, -4.0))
    next(way)
    sim.rov.place([-0.01, 0.0, -2.0])
    next(way)
    assert wanted_z_m == [-4.0, -4.0]


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (lambda v: goto(v, (1.0, 2.0)), "must be finite and of shape"),
        (lambda v: goto(v, (0.0, 0.0, 3.0)), "z must be at most 0 m, the mean water surface"),
        (lambda v: goto(v, (1.0, 2.0, math.nan)), "must be finite"),
        (lambda v: goto(v, (500.0, 0.0, -3.0)), r"must be above the terrain, which reaches from x = -\S+ to \S+ m"),
        (lambda v: follow(v, [(1.0, 2.0, -3.0), (0.0, -500.0, -3.0)]), "must be above the terrain"),
        (lambda v: goto(v, (1.0, 2.0, -3.0), speed_m_s=0.0), "speed_m_s = 0.0 m/s: must be positive"),
        (lambda v: goto(v, (1.0, 2.0), altitude_m=-1.0), "altitude_m = -1.0 m: must be positive"),
        (lambda v: follow(v, [(1.0, 2.0, -3.0)]), "n at least 2"),
        (lambda v: hold(v, -1.0), "must be positive"),
        (lambda v: goto(v, (1.0, 2.0, -50.0)), r"must be above the terrain, whose height there is -5.00 m"),
        (lambda v: follow(v, [(1.0, 2.0, -3.0), (1.0, 3.0, -50.0)]), "must be above the terrain, whose height"),
        (lambda v: dive_to(v, 100.0), "depth_m = 100 m: must be above the terrain, whose height there is -5.00 m"),
        (lambda v: dive_to(v, -3.0), "depth_m = -3 m: must be at least 0 m, the mean water surface"),
        (lambda v: dive_to(v, math.nan), "depth_m = nan: must be a number"),
        (lambda v: turn_to(v, math.nan), "heading_rad = nan: must be a number"),
        (lambda v: goto(v, (1.0, 2.0, -3.0), speed_m_s=50.0), "speed_m_s = 50 m/s: must be at most 10 m/s"),
        (lambda v: follow(v, [(1.0, 2.0, -3.0), (1.0, 3.0, -3.0)], speed_m_s=50.0), "must be at most 10 m/s"),
        (lambda v: LawnMowerPlan([[0, 0], [9, 0], [9, 5]], speed_m_s=50.0), "must be at most 10 m/s"),
        (lambda v: LawnMowerPlan([[0, 0], [9, 0], [9, 5]], line_spacing_m=0.0), "line_spacing_m = 0.0 m: must be pos"),
    ],
)
def test_moves_refuse_bad_values(step, words: str) -> None:
    sim = Simulator("pool")
    sim.rov.release()
    with pytest.raises(ValueError, match=words):
        next(step(OwnVehicle(sim.rov, sim)))


def test_a_target_is_over_the_terrain_up_to_its_edge() -> None:
    rov = Simulator("pool").rov
    edge = rov.beyond_terrain(1e6, 0.0)
    assert edge is not None
    x_m = float(edge.split(" to ")[1].split()[0])
    assert rov.beyond_terrain(x_m, 0.0) is None and rov.beyond_terrain(x_m + 1e-3, 0.0) == edge


class Remote:
    """A vehicle as `uwsim.missions.Vehicle` documents it, which is no OwnVehicle: it reaches its targets at once."""

    def __init__(self) -> None:
        self.name, self.time_s, self.sensors, self.all_stopped, self.released = "remote", 0.0, {}, False, True
        self.estimate, self.pose, self.velocity = self, self._pose(0.0), None

    @staticmethod
    def _pose(x_m: float, upright: float = 1.0) -> SimpleNamespace:
        matrix = np.eye(4)
        matrix[2, 2] = upright
        return SimpleNamespace(position_world_m=np.array([x_m, 0.0, -3.0]), world_from_body=matrix, yaw_rad=0.0)

    def telemetry(self) -> SimpleNamespace:
        return SimpleNamespace(battery_percent=50.0)


def test_goto_takes_any_vehicle_of_the_documented_protocol() -> None:
    """Far beyond any terrain, which a remote vehicle does not know."""
    remote = Remote()
    assert list(goto(remote, (0.2, 0.0, -3.0), within_m=0.5)) == []
    with pytest.raises(ValueError, match="z must be at most"):
        next(goto(remote, (5000.0, 0.0, 1.0)))


def test_a_lasting_tilt_is_warned_of_once() -> None:
    """At 40 degrees: after 10 s, not after 9 s, and not again; an upright moment restarts the count."""
    remote, heard = Remote(), []
    own = OwnVehicle(remote, remote, hear=heard.append)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for time_s, tilt_deg in ((0.0, 40.0), (9.0, 40.0), (9.5, 20.0), (10.0, 40.0), (19.0, 40.0)):
            remote.time_s = time_s
            own.watch_tilt(math.cos(math.radians(tilt_deg)))
        remote.time_s = 20.0
        with pytest.raises(TiltWarning, match="'remote': has been tilted by more than 30 deg for 10 s, now by 40 deg"):
            own.watch_tilt(math.cos(math.radians(40.0)))
        remote.time_s = 60.0
        own.watch_tilt(math.cos(math.radians(40.0)))
    assert [(event.name, event.values) for event in heard] == [("tilted", {"tilt_deg": 40.0, "duration_s": 10.0})]


def test_a_mission_watches_the_tilt() -> None:
    """Placed on its side, at 40 degrees, in every period."""
    sim = Simulator("pool")
    sim.rov.release()
    own = OwnVehicle(sim.rov, sim)
    heeled = [math.sin(math.radians(20.0)), 0.0, 0.0, math.cos(math.radians(20.0))]
    with pytest.warns(TiltWarning, match="'rov'"):
        for pause in hold(own, 12.0):
            sim.wait(pause.duration_s)
            sim.rov.place([0.0, 0.0, -2.0], heeled)


def test_several_vehicles_fly_one_mission_in_one_process() -> None:
    sim = Simulator("pair")
    places = {"rov": (-5.0, 10.0, -4.0), "scout": (5.0, -10.0, -6.0)}

    def mission(vehicles):
        vehicles["rov"].undock()
        yield from parallel(*(goto(vehicles[name], place) for name, place in places.items()))

    run(mission, sim.vehicles, sim)
    for name, place in places.items():
        assert np.linalg.norm(sim.vehicles[name].pose.position_world_m - place) < 1.0, name

    def alike(vehicle):
        vehicle.log("here")
        yield wait(1.0)

    events = []
    run(alike, sim.vehicles, sim, hear=events.append)
    assert [event.vehicle for event in events] == ["rov", "scout"]
