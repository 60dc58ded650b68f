"""Aliases, for one version: a survey is a mission flown by uwsim.flight with a map."""
