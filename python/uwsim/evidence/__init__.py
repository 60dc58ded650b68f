"""Evidence that results can be trusted: validation, reproduced figures, scenario checks, fingerprints."""
