"""Commands for the acoustic link."""
