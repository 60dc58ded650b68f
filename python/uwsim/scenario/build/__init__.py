"""Conversion of a checked scenario to objects of the native core; none of it is done elsewhere."""
