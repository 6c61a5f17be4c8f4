"""What a person may be called."""

from __future__ import annotations

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

LONGEST = 200
SEPARATORS = "/\\"  # of paths: whoever makes files of people's names is not led elsewhere


def checked_name(name: object) -> str:
    """Return a name that prints on one line and reads the same wherever it is shown.

    Parameters
    ----------
    name
        1 to 200 printable characters, without blanks at either end and without slashes.

    Raises
    ------
    HarmonicFaceError
        Anything else.

    Examples
    --------
    >>> checked_name("Ada Lovelace")
    'Ada Lovelace'
    """
    if not isinstance(name, str):
        raise HarmonicFaceError(f"name: expected a text, got {_validate.describe(name)}")
    if not 0 < len(name) <= LONGEST or not name.isprintable() or name != name.strip():
        expected = f"1 to {LONGEST} printable characters without blanks at the ends"
        raise HarmonicFaceError(f"name: expected {expected}, got {ascii(name)!s:.80}")
    if any(separator in name for separator in SEPARATORS):
        raise HarmonicFaceError(f"name: expected one without slashes, got {ascii(name)!s:.80}")
    return name
