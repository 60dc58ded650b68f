"""Who may command a vehicle through a channel, and what becomes of a command whose sender falls silent."""
