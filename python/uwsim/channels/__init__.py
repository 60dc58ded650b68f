"""Channels: a simulator's topics and services, and the messages that they carry."""

from uwsim.channels.channel import Channel, Service, keep_up, require_live
from uwsim.channels.diagnostics import diagnostics_channel
from uwsim.channels.table import ORIGINS, Table, channels, services

__all__ = [
    "ORIGINS",
    "Channel",
    "Service",
    "Table",
    "channels",
    "diagnostics_channel",
    "keep_up",
    "require_live",
    "services",
]
