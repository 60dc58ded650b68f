"""The command that makes a scenario of a file of others."""
