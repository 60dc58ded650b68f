"""Packs messages into a few bytes for a modem, and unpacks them. Content that is not packed is lost."""

from uwsim.link.packing.packings import PACKINGS, Packing, packing_of

__all__ = ["PACKINGS", "Packing", "packing_of"]
