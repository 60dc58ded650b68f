"""The table of doors in SECURITY.md."""

from pathlib import Path

from uwsim.bridges.doors.table import table

PAGE = Path(__file__).parents[2] / "SECURITY.md"
BEGIN, END = "<!-- doors: written by tools/reference -->", "<!-- end of doors -->"


def security_page() -> str:
    """Return SECURITY.md with the present table. Raises ValueError if its place is missing."""
    before, _, rest = PAGE.read_text().partition(f"{BEGIN}\n")
    _, found, after = rest.partition(f"\n{END}")
    if not found:
        raise ValueError(f"{PAGE.name}: lacks '{BEGIN}' or '{END}'")
    return f"{before}{BEGIN}\n{table()}\n{END}{after}"
