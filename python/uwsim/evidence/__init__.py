"""Evidence that results can be trusted: validation, reproduced figures, checks of scenarios, fingerprints."""
