"""Link: carries packed messages between station and vehicles, with delays and losses."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.link.carrier import Carrier
    from uwsim.link.seen import is_seen, seen_channels

__all__ = ["Carrier", "is_seen", "seen_channels"]
__getattr__ = lazy(__name__, {"Carrier": "carrier", "is_seen": "seen", "seen_channels": "seen"})
