"""Evidence for the results: validation, reproduced figures, checks of scenarios, fingerprints."""
