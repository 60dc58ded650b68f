"""The operator's side: the station with its page, and the pilot's terminal."""
