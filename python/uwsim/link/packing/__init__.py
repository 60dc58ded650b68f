"""Packing of messages into few bytes for a modem, and unpacking: only the carried content arrives."""

from uwsim.link.packing.packings import PACKINGS, Packing, packing_of

__all__ = ["PACKINGS", "Packing", "packing_of"]
