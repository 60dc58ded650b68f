"""The kinds of life, one file each; see uwsim.scenario.spec.cover."""
