"""The link in use: messages between station and vehicles pass through it packed, delayed, or not at all."""

from uwsim.link.carrier import Carrier
from uwsim.link.seen import is_seen, seen_channels

__all__ = ["Carrier", "is_seen", "seen_channels"]
