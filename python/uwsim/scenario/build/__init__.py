"""Conversion of a validated scenario to objects of the native core; all such conversion is done here."""
