"""Maps of more pixels than the memory holds: refused in one line, before anything is made."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import harmonicface as hf
from harmonicface import _memory
from harmonicface.lighting.layouts import LAYOUTS, layout_named
from harmonicface.lighting.prefiltered import irradiance_map, reflection_map

SKY = hf.EnvironmentMap(np.ones((4, 8)))
MAKERS: dict[str, Callable[[int], Any]] = {
    "irradiance map": lambda size: irradiance_map(SKY, size),
    "irradiance map by harmonics": lambda size: irradiance_map(SKY, size, order=2),
    "reflection map": lambda size: reflection_map(SKY, [1.0, 0.5], size),
    "converted": lambda size: SKY.converted("latlong", size),
    "natural": lambda size: hf.lights.natural(0, size),
}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
@pytest.mark.parametrize("size", [10**7, 10**30], ids=["ten million", "beyond integers"])
def test_huge_sizes(make: Callable[[int], Any], size: int) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=rf"^latlong map of {size} x {2 * size} pixels: need .* GB") as found:
        make(size)
    assert "\n" not in str(found.value)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_asks_first(layout: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shape = layout_named(layout).shape(8)
    needed = 48 * int(np.prod(shape))
    monkeypatch.setattr(_memory, "physical_memory", lambda: needed)
    assert layout_named(layout).directions(shape).shape == (*shape, 3)
    monkeypatch.setattr(_memory, "physical_memory", lambda: needed - 1)
    message = f"^{layout} map of {' x '.join(map(str, shape))} pixels: need"
    with pytest.raises(hf.HarmonicFaceError, match=message):
        layout_named(layout).directions(shape)
    with pytest.raises(hf.HarmonicFaceError, match=message):
        SKY.converted(layout, 8)
