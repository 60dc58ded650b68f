"""The station as a guest of a server: its sessions, its members and their services."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from uwsim.channels.guest import Node
from uwsim.channels.table import Wire, checked_wire
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.flights.flights import FOLDER, Bounds, Flights
from uwsim.operator.station.services.services import Services
from uwsim.operator.station.sessions.pulse import Pulse
from uwsim.operator.station.sessions.sessions import Sessions, Show
from uwsim.operator.station.start.choice import catalog


class Station:
    """The operator's station: a guest of a rosbridge server, to which `show` passes simulators.

        station = Station()
        with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
            ...

    offered, link: the scenario that is preselected on the start screen, and its modem if it differs from the
    scenario's. is_fixed: whether to run a single simulator, passed to `run`, without a start screen. truth: whether
    pilots may see the vehicle's true position. wire, origin: see uwsim.channels. If origin is None, it is the world's
    or, for a session that joins the user's rosbridge, the scenario's. threads: the number of threads of simulators.
    folder: where `save` writes. keep_flights: how many automatically recorded flights to keep in `folder`/flights, or
    None to record and list none. Raises ValueError for invalid values. start, run, run_exercise, present: of
    `Sessions`.
    """

    name = "/station"

    def __init__(
        self,
        *,
        offered: str = "lake",
        link: str | None = None,
        is_fixed: bool = False,
        truth: bool = True,
        wire: Wire = "both",
        origin: str | Sequence[float] | None = None,
        threads: int | None = None,
        folder: Path | None = None,
        keep_flights: Bounds | None = None,
    ) -> None:
        # Checked here, so that errors do not appear only when a pilot starts the first simulator.
        checked_wire(wire, "world" if origin is None else origin)
        folder = folder or Path.cwd()
        self.lease = Lease()
        self._pulse = Pulse(self.lease)
        self.sessions = Sessions(
            self.lease, self._pulse.wake, self._pulse.publish, offered=offered, is_fixed=is_fixed, folder=folder,
            threads=threads, origin=origin, truth=truth, wire=wire,
            flights=None if keep_flights is None else Flights(folder / FOLDER, keep_flights, threads),
        )  # fmt: skip
        self.start, self.run = self.sessions.start, self.sessions.run
        self.run_exercise, self.present = self.sessions.run_exercise, self.sessions.present
        self.services = Services(self.sessions, self.lease, self._pulse.publish, link).all()

    def __repr__(self) -> str:
        return f"<Station: {self.sessions.phase}, offers '{self.sessions.offered}'>"

    # Called by the graph

    def connect(self, node: Node) -> None:
        """Receive the node through which the station takes part in the graph."""
        self.sessions.connect(node)

    def left(self, client: str) -> None:
        """Remove a closed connection. If it was the pilot's, set efforts to zero."""
        if self.lease.leave(client):
            self.sessions.change_pilot()
        self.sessions.editor.left(client)
        if not self.lease.members:
            self.sessions.prepared.forget()  # no client is left at the start screen
        self._pulse.publish()

    def demanded(self) -> None:
        """Called when a topic gets its first subscriber: a picture may be due."""
        self._pulse.wake()

    def serving(self, show: Show) -> Self:
        """Start passing simulators to a server."""
        self.sessions.show = show
        return self

    def __enter__(self) -> Self:
        self._pulse.start(self.sessions)
        if not self.sessions.is_fixed:  # reads all files ahead, which takes half a second the first time
            offered = self.sessions.offered
            threading.Thread(target=catalog, args=(offered,), name="uwsim-catalog", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the simulator."""
        self._pulse.close()
        self.sessions.close()
