"""Seconds, bytes and errors as a person reads them: three figures and the unit that suits."""

from __future__ import annotations

TIMES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
SIZES = ((2**30, "GiB"), (2**20, "MiB"), (2**10, "KiB"), (1, "B"))


def spelled_seconds(seconds: float | None) -> str:
    """Return a time, "" if there is none.

    Examples
    --------
    >>> spelled_seconds(0.00123), spelled_seconds(75.25), spelled_seconds(None)
    ('1.23 ms', '75.2 s', '')
    """
    if seconds is None:
        return ""
    size, name = next((pair for pair in TIMES if seconds >= pair[0]), TIMES[-1])
    return f"{three_figures(seconds / size)} {name}"


def spelled_bytes(count: int | None) -> str:
    """Return an amount of memory, "" if there is none.

    Examples
    --------
    >>> spelled_bytes(147456), spelled_bytes(12)
    ('144 KiB', '12 B')
    """
    if count is None:
        return ""
    size, name = next((pair for pair in SIZES if abs(count) >= pair[0]), SIZES[-1])
    return f"{three_figures(count / size)} {name}"


def spelled_error(error: float | None) -> str:
    """Return an error, "" if there is none.

    Examples
    --------
    >>> spelled_error(0.0), spelled_error(12.345), spelled_error(3.21e-9)
    ('0', '12.3', '3.2e-09')
    """
    if error is None:
        return ""
    return f"{error:.1e}" if 0 < abs(error) < 1e-3 else three_figures(error)


def three_figures(value: float) -> str:
    """Return a number to three figures, never with an exponent below a million.

    Examples
    --------
    >>> [three_figures(value) for value in (0.0, 0.0456, 1.5, 455.2, 20000.0, float("nan"))]
    ['0', '0.0456', '1.5', '455', '20000', 'nan']
    """
    return f"{value:.0f}" if 100 <= abs(value) < 1e6 else f"{value:.3g}"
