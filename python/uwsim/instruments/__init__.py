"""The vehicle's perception: sensors and their readings, sonars, cameras."""
