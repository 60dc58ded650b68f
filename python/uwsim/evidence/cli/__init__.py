"""Commands for validation, identification and reports."""
