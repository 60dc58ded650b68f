"""Generators of the reference pages, which are derived from the code."""
