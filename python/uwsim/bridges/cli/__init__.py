"""Commands for servers and nodes."""
