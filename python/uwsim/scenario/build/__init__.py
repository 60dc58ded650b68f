"""Converts a validated scenario to native core objects; all such conversion is done here."""
