"""Album: the portraits that were asked for last, as many as fit in a bounded memory."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

from harmonicface.gallery.enrolled.portrait import Portrait

MOST_BYTES = 1 << 29  # about 900 people at 96 x 84


class Album:
    """Portraits by the place of whom they show; those that were asked for least recently make room for others.

    Parameters
    ----------
    portrait
        Makes one.
    most_bytes
        Of all of them together; the last one asked for stays even if it is larger.
    """

    def __init__(self, portrait: Callable[[int], Portrait], most_bytes: int = MOST_BYTES) -> None:
        self._portrait, self._most = portrait, most_bytes
        self._kept: OrderedDict[int, Portrait] = OrderedDict()

    def __getitem__(self, place: int) -> Portrait:
        if place not in self._kept:
            self._kept[place] = self._portrait(place)
            self._make_room()
        self._kept.move_to_end(place)
        return self._kept[place]

    @property
    def nbytes(self) -> int:
        """Memory of the pictures that are kept."""
        return sum(portrait.nbytes - portrait.template.nbytes for portrait in self._kept.values())

    def forget(self) -> None:
        """Let go of all: places have changed."""
        self._kept.clear()

    def _make_room(self) -> None:
        # pictures are made after a portrait is asked for, so the sum is taken anew: cheap beside making one
        while self.nbytes > self._most and len(self._kept) > 1:
            self._kept.popitem(last=False)
