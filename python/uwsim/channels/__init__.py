"""What is said and heard: the table of channels, and the messages that they carry."""

from uwsim.channels.channel import Channel, Service
from uwsim.channels.table import ORIGINS, channels, services

__all__ = ["ORIGINS", "Channel", "Service", "channels", "services"]
