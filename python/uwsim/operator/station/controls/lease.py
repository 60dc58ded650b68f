"""The lease of the controls: one member is the pilot, the others watch."""

from __future__ import annotations

NAME_MAX = 40
ASK_AGAIN_S = 30.0
"""Minimum time between requests under one name, over all connections, so that a watcher cannot pester the pilot."""


class Lease:
    """The members of a station, by connection, and which of them is the pilot.

    pilot: the pilot's connection, or "". asking: the members who have requested the controls, in order. lost_by: the
    name of a pilot whose connection was lost, until someone takes the controls or that simulator ends, or "".
    """

    def __init__(self) -> None:
        self.members: dict[str, str] = {}
        self.pilot = ""
        self.asking: list[str] = []
        self.lost_by = ""
        self._asked_s: dict[str, float] = {}  # by name

    @property
    def pilot_name(self) -> str:
        """The pilot's name, or "" for none."""
        return self.members.get(self.pilot, "")

    def join(self, client: str, name: object) -> None:
        """Register a connection as a named member. Raises ValueError."""
        if not isinstance(name, str) or not name.strip() or len(name) > NAME_MAX or not name.isprintable():
            raise ValueError(f"name = {str(name)[:NAME_MAX]!r}: must have 1 to {NAME_MAX} printable characters")
        self.members[client] = name.strip()

    def leave(self, client: str) -> bool:
        """Remove a closed connection; return whether it was the pilot's."""
        name = self.members.pop(client, "")
        if client in self.asking:
            self.asking.remove(client)
        was_pilot = client == self.pilot
        if was_pilot:
            self.pilot, self.lost_by = "", name
        return was_pilot

    def request(self, client: str, now_s: float, *, is_silent: bool = False) -> None:
        """Give the controls to a member if they are free, or if the pilot's connection seems dead (is_silent).

        Otherwise record the request and raise ValueError.
        """
        self.require_member(client)
        if self.pilot not in ("", client) and not is_silent:
            wait_s = self._ask(client, now_s)
            note = f"you may ask again in {wait_s:.0f} s" if wait_s > 0 else "your wish is shown there"
            raise ValueError(f"{self.pilot_name} has the controls; {note}")
        self._set_pilot(client)

    def hand_over(self, client: str, to: object) -> None:
        """Hand over the controls to a member, or release them if `to` is "". Raises ValueError."""
        self.require_pilot(client)
        if not isinstance(to, str) or (to and to not in self.members):
            raise ValueError(f"to = {str(to)[:NAME_MAX]!r}: is not a member")
        self._set_pilot(to)

    def take_if_free(self, client: str) -> bool:
        """Give the controls to a member if they are free; return whether the pilot has changed."""
        if self.pilot or client not in self.members:
            return False
        self._set_pilot(client)
        return True

    def require_pilot(self, client: str) -> None:
        """Raise ValueError unless this connection has the controls."""
        if client != self.pilot or not client:
            who = f"{self.pilot_name} has the controls" if self.pilot else "nobody has the controls: take them"
            raise ValueError(who)

    def _ask(self, client: str, now_s: float) -> float:
        """Record a request, unless its name made one recently; return the time [s] until the next is allowed."""
        if client in self.asking:
            return 0.0
        self._asked_s = {name: at_s for name, at_s in self._asked_s.items() if now_s - at_s < ASK_AGAIN_S}
        name = self.members[client]
        if name in self._asked_s:
            return self._asked_s[name] + ASK_AGAIN_S - now_s
        self._asked_s[name] = now_s
        self.asking.append(client)
        return 0.0

    def _set_pilot(self, client: str) -> None:
        self.pilot, self.lost_by = client, ""
        if client in self.asking:
            self.asking.remove(client)

    def require_member(self, client: str) -> None:
        """Raise ValueError unless this connection has joined."""
        if client not in self.members:
            raise ValueError("join first")
