"""The requests, responses and topic messages that the page and the server exchange."""
