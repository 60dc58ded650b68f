"""The controls: their lease, the efforts of the pilot, a plan."""
