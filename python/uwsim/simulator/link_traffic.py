"""The table in a report with the numbers of messages sent, delivered, lost and late, by topic and sender."""

from __future__ import annotations

from typing import NamedTuple

from uwsim.simulator.network import STATION
from uwsim.simulator.simulator import Simulator

HEADINGS = ("channel", "from", "given", "sent", "delivered", "lost", "late", "bytes", "delay")


class LinkRow(NamedTuple):
    """Message statistics for one topic and sender.

    given: submitted to the modem; messages that were replaced by newer ones before they were sent count as neither sent
    nor late. lost: sent, but lost in the water. late: not sent, because their lifetime had ended or the queue was full.
    bytes_delivered: payloads only. delay_s: mean time from submission to arrival.
    """

    topic: str
    sender: str
    given: int
    sent: int
    delivered: int
    lost: int
    late: int
    bytes_delivered: int
    delay_s: float

    def texts(self) -> tuple[str, ...]:
        """Return the row as text, in the order of HEADINGS."""
        delay = f"{self.delay_s:.2f} s" if self.delivered else "-"
        counts = (self.given, self.sent, self.delivered, self.lost, self.late, self.bytes_delivered)
        return (self.topic, self.sender, *(f"{count:,}" for count in counts), delay)


def link_rows(sim: Simulator) -> list[LinkRow]:
    """Return the rows for a simulator's link so far, with the station's messages last, or no rows without a link."""
    counts = [] if sim.link is None else sim.link.counts()
    rows = [
        LinkRow(
            one.topic, one.sender, one.given, one.sent, one.delivered, sum(one.lost.values()), one.late + one.refused,
            one.bytes_delivered, one.delay_s,
        )
        for one in counts
    ]  # fmt: skip
    return sorted(rows, key=lambda row: (row.sender == STATION, row.sender, row.topic))


def text_table(rows: list[LinkRow]) -> str:
    """Return the table as lines of text."""
    lines = [HEADINGS, *(row.texts() for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    return "\n".join(
        "  ".join(text.ljust(width) if column < 2 else text.rjust(width)
                  for column, (text, width) in enumerate(zip(line, widths, strict=True)))
        for line in lines
    )  # fmt: skip
