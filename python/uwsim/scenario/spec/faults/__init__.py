"""The kinds of faults, one file each; see uwsim.scenario.spec.fault."""
