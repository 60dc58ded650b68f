"""The fault `link`: the connection between station and vehicle is lost."""

from __future__ import annotations

from typing import Literal

from uwsim.scenario.spec.fault import FaultModel, Observer


class LinkLoss(FaultModel):
    """Nothing passes between station and vehicle: commands and the vehicle's messages over the link are lost."""

    kind: Literal["link"]

    cuts_link = True

    def unnoticed(self, observer: Observer) -> str:
        """See FaultModel."""
        return "" if observer.has_link else "the scenario has no link"
