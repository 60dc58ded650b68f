"""How messages become few bytes for a modem, and messages again: what arrives is what was carried."""

from uwsim.link.packing.packings import PACKINGS, Packing, packing_of

__all__ = ["PACKINGS", "Packing", "packing_of"]
