"""Link: carries packed messages between station and vehicles, with delays and losses."""

from uwsim.link.carrier import Carrier
from uwsim.link.seen import is_seen, seen_channels

__all__ = ["Carrier", "is_seen", "seen_channels"]
