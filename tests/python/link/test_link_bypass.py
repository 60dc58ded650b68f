"""The table in docs/guides/link.md lists exactly the data that bypass the link."""

from __future__ import annotations

import fnmatch
import re
from concurrent.futures import Future

from docs_pages import page_named
from uwsim.base.commands import COMMANDS, SET_BOOL
from uwsim.bridges.foxglove.shows import shows_of
from uwsim.channels import Channel, Table
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.delivery.outgoing import Outgoing
from uwsim.channels.served import served_table
from uwsim.link import Carrier
from uwsim.link.carried import carried_channels
from uwsim.live import LiveSimulator
from uwsim.operator.station import Station
from uwsim.operator.station.sessions.running import Running
from uwsim.simulator.network import STATION
from uwsim.simulator.simulator import Simulator

PAGE = page_named("link").read_text()
OVER = {"station/drive", "station/all_stop", "station/command"}
"""The station's services that send commands over the link; see the last test."""
TOLD = ("track", "map")
"""Foxglove scenes built from data that arrived over the link; see test_foxglove."""


CARRIED = {name for name, command in COMMANDS.items() if command.crosses_link}
REQUESTS = {
    "set_wrench": {"force_body_n": [1.0, 0.0, 0.0]}, "set_thrusters": {"commands": {}}, "set_fins": {"angles_rad": {}},
    "hold": {"heading": True},
}  # fmt: skip
"""Requests for command services that require arguments, or do nothing without."""


def table() -> list[str]:
    """Return the names in the page's table, as patterns."""
    rows = PAGE.split("| what | names | why |")[1].split("\n\n")[0].splitlines()[2:]
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row.split("|")[2])]


def own_name(name: str, sim: Simulator) -> str:
    """Return a name without its vehicle prefix, which is present if there are several vehicles."""
    first, _, rest = name.partition("/")
    return rest if rest and first in sim.vehicles else name


def is_order(service: str) -> bool:
    """Return True if a service commands a vehicle."""
    name = service.rpartition("/")[2]
    return name in CARRIED or "lights/" in service


def bypassing(scenario: str) -> set[str]:
    """Return the names of everything that clients can see or call that bypasses the scenario's link."""
    sim = Simulator(scenario, link="tether")
    live = LiveSimulator(sim)
    table = served_table(live)
    carried = {one.channel.name for one in carried_channels(table.channels, sim)}
    seen: list[Channel] = Carrier(live, table).channels
    station = Running(live, Node(), lambda: None, wire="both", origin="world", truth=True)
    topics = {one.name for one in station.topics()} - {f"station/{size}/{name}" for name in station.views.aboard
                                                       for size in ("view", "small")}  # fmt: skip
    shows = {one.topic for one in shows_of(live, seen, Feed(live), Outgoing("test"), lambda *_: None)}
    shows = {topic for topic in shows if not topic.endswith(TOLD)}
    asked = {one.name for one in table.services if not is_order(one.name)}
    return {own_name(name, sim) for name in {one.name for one in seen} - carried | asked} | topics | shows


class Node:
    """Stand-in for the node that a Station uses."""


def test_all_that_bypasses_the_link_is_in_the_table_and_nothing_else() -> None:
    found = bypassing("lake") | bypassing("pair") | set(COMMANDS) - CARRIED
    found |= {one.name for one in Station().services} - OVER
    listed = table()
    assert not sorted(name for name in found if not any(fnmatch.fnmatchcase(name, one) for one in listed))
    assert not [one for one in listed if not fnmatch.filter(found, one)], "names that there are not"


def test_every_order_to_a_vehicle_by_service_is_a_message_of_the_link() -> None:
    sim = Simulator("lake", link="tether")
    table = Table(sim)
    with LiveSimulator(sim, paused=True) as live, Carrier(live, table) as carrier:
        orders = [one for one in carrier.over(table.services) if is_order(one.name)]
        assert {"release", "undock", "dock", "override_failsafe", "all_stop"} <= {one.name for one in orders}
        for order in orders:
            before = given(sim)
            request = REQUESTS.get(order.name) or ({"data": True} if order.type == SET_BOOL else {})
            found = order.call(live, request)
            assert (found.result() if isinstance(found, Future) else found)["success"], order.name
            assert given(sim) == before + 1 and not sim.rov.released, order.name


def test_the_pilot_s_hands_and_commands_at_the_station_are_messages_of_the_link() -> None:
    sim = Simulator("lake", link="tether")
    with LiveSimulator(sim, paused=True) as live:
        running = Running(live, Node(), lambda: None, wire="both", origin="world", truth=True)
        running.carrier.start()
        running.pilot.drive({"vehicle": "rov", "surge": 0.5}).result()
        assert given(sim) == 1 and not any(sim.rov.effort)
        running.pilot.all_stop({"vehicle": "rov"}).result()
        assert given(sim) == 2 and not sim.rov.all_stopped
        for name in sorted(CARRIED & {"release", "undock", "dock"}):
            before = given(sim)
            running.far.command(name, vehicle="rov").result()
            assert given(sim) == before + 1 and not sim.rov.released


def given(sim: Simulator) -> int:
    """Return how many messages the station has passed to its modem."""
    return sum(one.given for one in sim.link.counts() if one.sender == STATION)
