"""The dynamics of bodies and of the packaged vehicles, held against closed forms and what others published."""
