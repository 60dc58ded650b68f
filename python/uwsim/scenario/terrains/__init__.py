"""The sources of terrain, one file each; see uwsim.scenario.spec.terrain."""
