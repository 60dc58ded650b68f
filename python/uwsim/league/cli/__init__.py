"""The commands of the league."""
