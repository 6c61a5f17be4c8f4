"""The header of a Radiance HDR file."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image
from harmonicface.io.radiance import radiance_exposure

PICTURE = np.random.default_rng(0).uniform(0.5, 4, (6, 9, 3)).astype(np.float32)
FILE = cv2.imencode(".hdr", PICTURE[..., ::-1])[1].tobytes()


def with_line(line: bytes) -> bytes:
    return FILE.replace(b"\n\n", b"\n" + line + b"\n\n", 1)


def test_numbers_are_divided_by_all_exposures(tmp_path: Path) -> None:
    for name, data in (("plain", FILE), ("exposed", with_line(b"EXPOSURE=2\nEXPOSURE= 4.0"))):
        (tmp_path / f"{name}.hdr").write_bytes(data)
    plain, exposed = (read_image(tmp_path / f"{name}.hdr") for name in ("plain", "exposed"))
    np.testing.assert_allclose(plain, PICTURE, rtol=0, atol=4 / 128)  # eight bits below the brightest colour
    np.testing.assert_allclose(exposed, plain / 8, rtol=1e-6)
    assert radiance_exposure(FILE) == 1.0


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (with_line(b"EXPOSURE=0"), "expected a Radiance exposure above 0, got '0'"),
        (with_line(b"EXPOSURE=bright"), "expected a Radiance exposure above 0, got 'bright'"),
        (
            FILE.replace(b"32-bit_rle_rgbe", b"32-bit_rle_xyze"),
            "expected Radiance colours 32-bit_rle_rgbe, got '32-bit_rle_xyze'",
        ),
        (
            FILE.replace(b"-Y 6 +X 9", b"+Y 6 +X 9"),
            r"expected a Radiance picture that runs from top left .*, got '\+Y 6 \+X 9'",
        ),
        (b"", "expected a whole image, got one cut short or corrupt"),
    ],
)
def test_what_is_refused(tmp_path: Path, data: bytes, message: str) -> None:
    (tmp_path / "a.hdr").write_bytes(data)
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_image(tmp_path / "a.hdr")
    assert "\n" not in str(caught.value)
    assert "OpenCV" not in str(caught.value)
