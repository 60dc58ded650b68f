"""Channels: a simulator's topics and services, and the messages that they carry."""

from uwsim.channels.channel import Authority, Channel, Delivery, OverLink, Service, require_live, start_updates
from uwsim.channels.families.diagnostics import diagnostics_channel
from uwsim.channels.table import ORIGINS, Table, channels

__all__ = [
    "ORIGINS",
    "Authority",
    "Channel",
    "Delivery",
    "OverLink",
    "Service",
    "Table",
    "channels",
    "diagnostics_channel",
    "require_live",
    "start_updates",
]
