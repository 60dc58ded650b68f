"""What is said and heard: the table of channels, and the messages that they carry."""
