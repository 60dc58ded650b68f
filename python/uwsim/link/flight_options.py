"""The link of a flight takes part whenever the scenario, or `--link`, has one."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.flight.attachment import Attachment, AttachmentOptions, Departure


@dataclass(frozen=True)
class LinkOptions(AttachmentOptions):
    """No options: the link is the simulator's."""

    def attach(self, flight: Departure) -> Attachment | None:
        """Return what carries a flight's messages, if the simulator has a link."""
        if flight.sim.link is None:
            return None
        from uwsim.link.flight import LinkAttachment

        return LinkAttachment(flight)
