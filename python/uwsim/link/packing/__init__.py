"""Packs messages into a few bytes for a modem, and unpacks them; content that is not packed does not arrive."""

from uwsim.link.packing.packings import PACKINGS, Packing, packing_of

__all__ = ["PACKINGS", "Packing", "packing_of"]
