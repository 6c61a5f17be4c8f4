"""What of a parser's exception is told: what is about the file, nothing about the parser."""

from __future__ import annotations

import json

import pytest

from harmonicface.io._reasons import reason_of

NOT_JSON = json.JSONDecodeError("Expecting value", "x", 0)


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (ValueError("row 3 has 2 numbers"), ": row 3 has 2 numbers"),
        (
            ValueError("changed from 6 to 3 at row 2; use `usecols` to select a subset"),
            ": changed from 6 to 3 at row 2",
        ),
        (ValueError('loadtxt: input contained no data: "<_io.BytesIO object at 0x7f4a>"'), ""),
        (ValueError("first\nsecond"), ": first"),
        (ValueError("\x1b[2Jgone"), ": ?[2Jgone"),
        (ValueError("x" * 1000), ": " + "x" * 200),
        (ValueError(), ""),
        (NOT_JSON, ": its JSON cannot be read"),
        (IndexError("index 8 is out of bounds for axis 0 with size 3"), ": index 8, beyond the 3 that there are"),
        (IndexError("list index out of range"), ""),
        (KeyError("attributes"), ""),
        (DeprecationWarning("Arrays of 2-dimensional vectors are deprecated."), ""),
    ],
)
def test_what_is_told(error: Exception, told: str) -> None:
    assert reason_of(error) == told
