"""Replaces the generated part of a page: what stands between two markers."""


def between(page: str, begin: str, end: str, text: str) -> str:
    """Return a page with a new text between two markers that it has."""
    before, rest = page.split(begin)
    _, after = rest.split(end)
    return f"{before}{begin}{text}{end}{after}"
