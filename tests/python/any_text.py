"""Any text, for Hypothesis, whose own takes two seconds in each process to sort all characters into categories."""

from hypothesis import strategies as st


def any_text(max_size: int, min_size: int = 0) -> st.SearchStrategy[str]:
    """Return a strategy for texts of all characters but surrogates."""
    codes = st.integers(0, 0xD7FF) | st.integers(0xE000, 0x10FFFF)
    return st.lists(codes.map(chr), min_size=min_size, max_size=max_size).map("".join)
