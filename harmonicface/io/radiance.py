"""What the header of a Radiance HDR file says of its numbers."""

from __future__ import annotations

import re

from harmonicface.errors import HarmonicFaceError

SETTING = re.compile(rb"^(EXPOSURE|FORMAT)\s*=\s*(\S+)\s*$", re.MULTILINE)
ORIENTATION = re.compile(rb"^-Y \d+ \+X \d+\s*$", re.MULTILINE)


def radiance_exposure(data: bytes) -> float:
    r"""Return the factor that the numbers of the file were multiplied by: the product of its EXPOSURE lines.

    Parameters
    ----------
    data
        The bytes of the file; its header ends at the first blank line, the size stands in the line behind.

    Raises
    ------
    HarmonicFaceError
        Colours other than RGB (XYZE), rows that do not run from top left, an exposure that is no number above 0.

    Examples
    --------
    >>> radiance_exposure(b"#?RADIANCE\nEXPOSURE=2\n\n-Y 1 +X 1\n")
    2.0
    """
    header, _, rest = data.partition(b"\n\n")
    if rest and not ORIENTATION.match(rest):
        size = rest.split(b"\n", 1)[0][:40].decode("latin-1")
        raise HarmonicFaceError(f"expected a Radiance picture that runs from top left (-Y h +X w), got {size!r}")
    exposure = 1.0
    for key, value in SETTING.findall(header):
        if key == b"FORMAT" and value != b"32-bit_rle_rgbe":
            raise HarmonicFaceError(f"expected Radiance colours 32-bit_rle_rgbe, got {value.decode('latin-1')!r}")
        if key == b"EXPOSURE":
            exposure *= _number(value)
    return exposure


def _number(text: bytes) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 1e-30 < value < 1e30:
        raise HarmonicFaceError(f"expected a Radiance exposure above 0, got {text.decode('latin-1')!r}")
    return value
