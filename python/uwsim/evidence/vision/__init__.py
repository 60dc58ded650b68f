"""How well cameras navigate: `uwsim range vision`."""
