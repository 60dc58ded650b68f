"""Who steers, and how: the lease of the controls, the pilot's efforts, a plan."""
