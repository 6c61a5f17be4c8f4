"""Reasons: what a parser's exception tells a person about a file."""

from __future__ import annotations

import json
import re

TELLING = (ValueError, EOFError, MemoryError, NotImplementedError)  # others speak of the parser, not of the file
BEYOND = re.compile(r"index (-?\d+) is out of bounds for axis \d+ with size (\d+)")
INSIDE = ("object at 0x", "Traceback", "numpy", "NumPy", "ndarray", "usecols")


def reason_of(error: Exception) -> str:
    """Return ": why" where the exception's text is about the file, otherwise nothing.

    Examples
    --------
    >>> reason_of(ValueError("row 3 has 2 numbers")), reason_of(IndexError("list index out of range"))
    (': row 3 has 2 numbers', '')
    """
    if isinstance(error, json.JSONDecodeError):
        return ": its JSON cannot be read"
    text = str(error).strip()
    beyond = BEYOND.search(text)
    if beyond:
        return f": index {beyond[1]}, beyond the {beyond[2]} that there are"
    if not text or not isinstance(error, TELLING):
        return ""
    parts = text.splitlines()[0].split(";")
    told = ";".join(part for part in parts if not any(word in part for word in INSIDE))
    told = "".join(sign if sign.isprintable() else "?" for sign in told).strip()
    return f": {told[:200]}" if told else ""
