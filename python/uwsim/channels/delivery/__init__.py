"""The way from a channel to its readers: each reading is made once, pictures apart, and queues are bounded."""
