"""The kinds of obstacles, one file each; see uwsim.scenario.spec.obstacle."""
