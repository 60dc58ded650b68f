"""The kinds of cover, one file each; see uwsim.scenario.spec.cover."""
