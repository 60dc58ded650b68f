"""The kinds of obstacles, by family; see uwsim.scenario.spec.obstacle."""
