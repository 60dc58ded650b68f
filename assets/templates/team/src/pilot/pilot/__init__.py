"""The team's pilot, and what drives it."""
