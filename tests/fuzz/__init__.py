"""Coverage-guided fuzzers of every reader of bytes from outside; `tools/fuzz` runs them."""
