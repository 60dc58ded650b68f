"""Logs of real flights: readers by content, what they hold and lack, and a model flown beside them."""
