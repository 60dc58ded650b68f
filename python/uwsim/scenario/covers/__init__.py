"""The kinds of cover, by family; see uwsim.scenario.spec.cover."""
