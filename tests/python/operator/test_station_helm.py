"""The pilot's controls: who holds them, the age of commands, and the reaction to silence."""

from typing import Any

import pytest

from uwsim import Simulator
from uwsim.channels.table import Table
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.controls.pilot import LeastDelay, Pilot
from uwsim.simulator import helm as rules


def test_one_has_the_controls_and_hands_them_over():
    lease = Lease()
    for client in "abc":
        lease.join(client, f"pilot {client}")
    lease.request("a", 0.0)
    with pytest.raises(ValueError, match="pilot a has the controls"):
        lease.request("b", 0.0)
    assert (lease.pilot, lease.asking) == ("a", ["b"])
    with pytest.raises(ValueError, match="pilot a"):
        lease.hand_over("b", "c")
    with pytest.raises(ValueError, match="is not a member"):
        lease.hand_over("a", "d")
    lease.hand_over("a", "b")
    assert (lease.pilot, lease.asking) == ("b", [])
    assert not lease.leave("a") and lease.leave("b")
    assert (lease.pilot, list(lease.members)) == ("", ["c"])
    with pytest.raises(ValueError, match="nobody has the controls"):
        lease.require_pilot("c")
    with pytest.raises(ValueError, match="join first"):
        lease.request("a", 0.0)
    for name in ("", " ", "x" * 41, "a\nb", None):
        with pytest.raises(ValueError, match="printable"):
            lease.join("a", name)


def test_a_name_asks_the_pilot_no_more_than_twice_a_minute_whatever_its_connections():
    lease = Lease()
    lease.join("a", "Ada")
    lease.request("a", 0.0)
    for k in range(5):
        lease.join(f"b{k}", "Bob")
        with pytest.raises(ValueError, match="your wish is shown there" if k == 0 else f"ask again in {30 - k} s"):
            lease.request(f"b{k}", float(k))
        assert lease.asking == (["b0"] if k == 0 else [])
        lease.leave(f"b{k}")
    lease.join("b9", "Bob")
    with pytest.raises(ValueError, match="your wish is shown there"):
        lease.request("b9", 30.0)
    assert lease.asking == ["b9"]


def test_age_is_what_a_message_lost_on_its_way_whatever_the_clocks():
    delay, drift = LeastDelay(), 2e-4  # drift of a poor quartz oscillator: 0.7 s per hour
    late, fresh = [], []
    for k in range(36_000):
        now_s = 1000.0 + 0.1 * k
        ages, late_s = (late, 0.8) if k % 100 == 50 else (fresh, 0.02)
        ages.append(delay.age_s(5.0 + (now_s - late_s) * (1.0 - drift), now_s))
    assert max(fresh) < 0.05 and min(late) > 0.75


@pytest.fixture
def flight():
    """A helm with a clock set by the test, on a paused simulator."""
    sim = Simulator("pool")
    now = [100.0]
    with LiveSimulator(sim, paused=True) as live:
        live.rov.release()
        yield live, Pilot(live, Table(sim).steering, clock=lambda: now[0]), now


def given(live):
    return [(e.tick, e.arguments["surge"]) for e in live.log if e.name == "set_effort"]


def drive(helm, now, **efforts):
    return helm.drive({"vehicle": "rov", "stamp_ms": 1e3 * now[0], **efforts}).result(10.0)


def beat(live, helm):
    helm.beat()
    live.read(lambda sim: None).result()


def test_efforts_hold_while_they_are_repeated_and_end_with_silence(flight):
    live, helm, now = flight
    assert drive(helm, now, surge=0.5) == {"success": True, "message": "", "tick": 0, "age_s": 0.0}
    for _ in range(10):
        live.step(10)
        now[0] += 0.2
        assert drive(helm, now, surge=0.5)["success"]
        helm.beat()
    held = [(10 * k, 0.5) for k in range(11)]
    assert given(live) == held
    now[0] += 0.49
    helm.beat()
    assert live.rov.effort[0] == 0.5
    now[0] += 0.02
    beat(live, helm)
    assert given(live) == [*held, (100, 0.0)] and not live.rov.effort.any()
    helm.beat()
    assert len(given(live)) == 12


def test_what_the_pilot_asks_for_takes_effect_what_is_no_effort_is_refused_and_another_begins_with_zero(flight):
    live, helm, now = flight
    for effort in (0.0, 0.5):
        drive(helm, now, surge=effort)
        live.command("set_effort", vehicle="rov", surge=-1.0).result(10.0)  # as another client's /key would
        assert drive(helm, now, surge=effort)["success"]
        assert live.rov.effort[0] == effort
    for wrong in ({"surge": 1.5}, {"yaw": "left"}, {"yaw": float("nan")}, {"vehicle": "boat"}, {"heave": True}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            helm.drive({"vehicle": "rov", **wrong})
    helm.release()
    live.read(lambda sim: None).result()
    assert not live.rov.effort.any()
    assert drive(helm, [now[0] - 5000.0], surge=0.2)["success"]  # from a different clock


def test_a_command_that_was_held_up_is_refused_and_keeps_nothing_alive(flight):
    live, helm, now = flight
    drive(helm, now, surge=0.5)
    for _ in range(3):
        now[0] += 0.2
        with pytest.raises(ValueError, match=r"0\.8 s late"):
            helm.drive({"vehicle": "rov", "surge": 1.0, "stamp_ms": 1e3 * (now[0] - 0.8)})
    beat(live, helm)
    assert given(live) == [(0, 0.5), (0, 0.0)]


def test_a_speed_hold_lasts_as_long_as_the_pilot_is_there_and_other_holds_stay(flight):
    live, helm, now = flight
    asked = {"heading": True, "depth": True, "speed": True}
    live.command("hold", vehicle="rov", **asked).result()
    helm.note_holds("rov", asked)
    for now[0] in (101.0, 102.0):  # the page repeats its efforts
        helm.drive({"vehicle": "rov"})
        assert helm.beat() == pytest.approx(1.5)
    for now[0], holds in ((103.4, {"heading", "depth", "speed"}), (103.51, {"heading", "depth"})):
        helm.beat()
        live.step(1)
        assert set(live.simulator.rov.holds.targets) == holds


def test_the_table_of_silences_gives_the_limits_of_pilots(flight: Any) -> None:
    _, pilot, _ = flight
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in (rules.__doc__ or "").splitlines()]
    found = {row[0]: tuple(row[1:3]) for row in rows if len(row) == 4}
    for name, timeout in (("efforts", pilot._silence), ("speed hold", pilot._cruise)):
        assert found[f"a pilot's {name}"] == (timeout.clock.name, f"{timeout.limit_s():g} s")
