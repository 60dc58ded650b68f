"""Link: carries messages between station and vehicles, packed, with delay and losses."""

from uwsim.link.carrier import Carrier
from uwsim.link.seen import is_seen, seen_channels

__all__ = ["Carrier", "is_seen", "seen_channels"]
