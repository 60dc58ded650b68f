"""The operator's side: the station with its web page, and the pilot's terminal."""
