"""The sonars: tables of makers, the sonar equation, and bent rays."""
