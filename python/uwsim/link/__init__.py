"""The link in use: what passes between station and vehicles goes through it, packed, late, or never."""

from uwsim.link.carrier import Carrier
from uwsim.link.seen import is_seen, seen_channels

__all__ = ["Carrier", "is_seen", "seen_channels"]
