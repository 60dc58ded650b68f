"""The lease of the controls: one member is the pilot, the others watch."""

from __future__ import annotations

NAME_MAX = 40


class Lease:
    """The members of a station, by connection, and which of them is the pilot. pilot: "" for none.

    asking: members who have requested the controls, in order.
    """

    def __init__(self) -> None:
        self.members: dict[str, str] = {}
        self.pilot = ""
        self.asking: list[str] = []

    def join(self, client: str, name: object) -> None:
        """Register a connection as a named member. Raises ValueError."""
        if not isinstance(name, str) or not name.strip() or len(name) > NAME_MAX or not name.isprintable():
            raise ValueError(f"name = {str(name)[:NAME_MAX]!r}: must have 1 to {NAME_MAX} printable characters")
        self.members[client] = name.strip()

    def leave(self, client: str) -> bool:
        """Remove a closed connection; return whether it was the pilot's."""
        self.members.pop(client, None)
        if client in self.asking:
            self.asking.remove(client)
        was_pilot = client == self.pilot
        if was_pilot:
            self.pilot = ""
        return was_pilot

    def take(self, client: str, *, is_silent: bool = False) -> None:
        """Give the controls to a member if they are free, or if the pilot's connection seems dead (is_silent).

        Otherwise record the request and raise ValueError.
        """
        self._require_member(client)
        if self.pilot not in ("", client) and not is_silent:
            if client not in self.asking:
                self.asking.append(client)
            raise ValueError(f"{self.members[self.pilot]} has the controls; your wish is shown there")
        self._give(client)

    def hand_over(self, client: str, to: object) -> None:
        """Pass the controls to a member, or release them if `to` is "". Raises ValueError."""
        self.require_pilot(client)
        if to != "" and to not in self.members:
            raise ValueError(f"to = {str(to)[:NAME_MAX]!r}: is not a member")
        self._give(str(to))

    def require_pilot(self, client: str) -> None:
        """Raise ValueError unless this connection has the controls."""
        if client != self.pilot or not client:
            who = f"{self.members[self.pilot]} has the controls" if self.pilot else "nobody has the controls: take them"
            raise ValueError(who)

    def _give(self, client: str) -> None:
        self.pilot = client
        if client in self.asking:
            self.asking.remove(client)

    def _require_member(self, client: str) -> None:
        if client not in self.members:
            raise ValueError("join first")
