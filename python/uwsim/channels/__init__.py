"""What is said and heard: the table of channels, and the messages that they carry."""

from uwsim.channels.channel import Channel, Service

__all__ = ["Channel", "Service"]
