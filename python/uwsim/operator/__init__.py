"""The operator's side: the station with its web page, and teleoperation from a terminal."""
