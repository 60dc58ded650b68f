"""Conversion of a validated scenario to objects of the native core; all of it is done here."""
