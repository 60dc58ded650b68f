"""The sockets that each option opens: the source of the table in SECURITY.md, which tools/reference writes."""

from __future__ import annotations

from uwsim.bridges.doors.door import ANYWHERE, EVERYONE, HOST, LOOPBACK, WEB, Door
from uwsim.bridges.requested import offered

SERVE = Door(
    "`serve`, `station`, `replay --as-topics`, `exercise --serve`", "TCP", 1, HOST, "rosbridge and the page", WEB
)
_BINARY = ("--ardusub", "--ardusub-binary")
ARDUSUB = (
    Door("`--ardusub`", "UDP", 1, "`--ardusub-host`, by default 127.0.0.1", "ArduSub's servo outputs",
         f"{EVERYONE}; while one sends frames, no other", ("--ardusub", "--ardusub-port", "0")),
    Door("`--ardusub-binary`", "UDP", 1, LOOPBACK, "the firmware's navigation",
         "the firmware's own process", _BINARY),
    Door("`--ardusub-binary`", "UDP", 2, ANYWHERE, "in the firmware: RC input at port 5501, motion at a free port",
         f"{EVERYONE}; the first steers, the second moves: a firewall must close them", _BINARY),
    Door("`--ardusub-binary`", "UDP", 2, "127.0.0.1 if `--ardusub-station` is", "in the firmware: MAVLink",
         "the station and this program", _BINARY),
)  # fmt: skip


def doors() -> tuple[Door, ...]:
    """Return all doors, those of the registered bridges included.

    Left out are those of Dask's workers, whose number depends on theirs.
    """
    return (SERVE, *ARDUSUB, *(door for plug in offered().values() for door in plug.doors))


def table() -> str:
    """Return the doors as a table in Markdown."""
    lines = ["| option | sockets | at | for | admits |", "|---|---|---|---|---|"]
    lines += [
        f"| {door.option} | {f'{door.count} {door.protocol}' if door.count else 'none'} | {door.address} | "
        f"{door.serves} | {door.admits}{'; it speaks first' if door.speaks_first else ''} |"
        for door in doors()
    ]
    return "\n".join(lines)
