"""The function `view`, which opens the operator's station for a simulator in a script, prompt or notebook."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import overload

from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.live.pace import Speed
from uwsim.live.vehicle import LiveVehicle
from uwsim.mapping import OccupancyMap
from uwsim.operator.framed import LOCAL_PAGES, Framed
from uwsim.operator.map_view import MapViewer
from uwsim.operator.station import Site, Station
from uwsim.scenario import Scenario
from uwsim.simulator.simulator import Simulator

SCENE = "/?view=scene"
"""The page, with the 3D view enlarged."""


class Viewer(Framed):
    """The station's page for a running simulator; see `view`.

    live: the LiveSimulator that steps it. url: the page. Close the viewer with `close`, or use it as a context manager.
    The simulator remains in the state in which the viewer left it, and can be stepped by its owner again.
    """

    live: LiveSimulator

    def __init__(self, live: LiveSimulator) -> None:
        self.live = live
        self._owns = not live.running
        station = Station(is_fixed=True)
        with ExitStack() as open_things:
            server = open_things.enter_context(
                RosbridgeServer(None, port=0, guests=[station], site=Site(station, framed_by=LOCAL_PAGES))
            )
            open_things.enter_context(station.serving(server.show))
            if self._owns:
                open_things.enter_context(live)
            station.run(lambda: live)
            self.url = server.url.replace("ws", "http", 1) + SCENE
            self._open_things = open_things.pop_all()

    @property
    def rov(self) -> LiveVehicle:
        """The scenario's first vehicle, which accepts commands from any thread."""
        return self.live.rov

    def close(self) -> None:
        """Close the page's server, and stop the simulator unless it was running before."""
        self._open_things.close()  # also stops the simulator
        if not self._owns and not self.live.running:
            self.live.start()

    def __repr__(self) -> str:
        return f"<Viewer at {self.url}: {self.live!r}>"


@overload
def view(
    sim: Simulator | LiveSimulator | Scenario | str | Path = "lake",
    *,
    speed: Speed = 1.0,
    paused: bool = False,
    browser: bool | None = None,
) -> Viewer: ...


@overload
def view(sim: OccupancyMap, *, browser: bool | None = None) -> MapViewer: ...


def view(
    sim: Simulator | LiveSimulator | Scenario | str | Path | OccupancyMap = "lake",
    *,
    speed: Speed = 1.0,
    paused: bool = False,
    browser: bool | None = None,
) -> Viewer | MapViewer:
    """Open the station's page, with its 3D view, for a simulator; return the Viewer. Or open a map's page.

        sim = uwsim.Simulator("lake")
        with uwsim.view(sim) as viewer:          # in a notebook, the last expression of a cell: uwsim.view(sim)
            viewer.rov.set_effort(surge=0.5)     # or fly it on the page
            viewer.live.clock.wait(10.0)         # simulated seconds
        sim.advance(1.0)                         # continues from there

    While the page is open, the simulator steps itself. Command it through `viewer.rov` or `viewer.live`, and do not
    step or command `sim`.

    For an OccupancyMap, the page shows its occupied voxels as they are now, and a MapViewer is returned; speed and
    paused have no effect.

    sim: a simulator, whose state is kept, a LiveSimulator, or the scenario to create one from. speed: simulated seconds
    per wall second, or "max". paused: whether to wait for `viewer.live.step(n)` or `viewer.live.resume()`. Neither has
    any effect on a LiveSimulator. browser: whether to open a browser window; by default, only on a desktop and outside
    notebooks. The server listens on 127.0.0.1, on a free port. Raises ScenarioError or ValueError for invalid
    arguments, OSError if no port is free.
    """
    if isinstance(sim, OccupancyMap):
        return MapViewer(sim).open(browser)
    live = sim if isinstance(sim, LiveSimulator) else LiveSimulator(sim, speed=speed, paused=paused)
    return Viewer(live).open(browser)
