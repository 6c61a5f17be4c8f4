"""Which shards are written again together with new entries, so that there are few shards and little is written twice.

Shards have classes: class c from 4 KiB * 8^c bytes, the last from 128 MiB. New entries take in all shards at the end of
the folder that are of a smaller class than what is written; and when what is written together with the shards of its
own class reaches the next class, these too. So classes never rise from the first shard to the last, fewer than eight
stand in each but the last, and whatever is written again has risen by a class: at most five times in its life, four
times if it came with 150 KB. This is a counter to the base 8 (the logarithmic method of Bentley and Saxe, 1980).
"""

from __future__ import annotations

from collections.abc import Sequence

SMALLEST = 1 << 12
FACTOR = 8
LAST = 5


def size_class(nbytes: int) -> int:
    """Return the class of a shard by its bytes.

    Examples
    --------
    >>> [size_class(n) for n in (1, 4095, 32768, 150_000, 1 << 27, 1 << 40)]
    [0, 0, 1, 1, 5, 5]
    """
    level = 0
    while level < LAST and nbytes >= SMALLEST * FACTOR ** (level + 1):
        level += 1
    return level


def taken_in(sizes: Sequence[int], new: int) -> int:
    """Return how many of the last shards are written again with new entries.

    Parameters
    ----------
    sizes
        Bytes of the shards, in their order.
    new
        Bytes of what is new.

    Examples
    --------
    >>> taken_in([150_000], 150_000), taken_in([1 << 20, 150_000], 1 << 28), taken_in([1 << 28] * 100, 1 << 28)
    (1, 2, 0)
    >>> taken_in([4096] * 7, 4096), taken_in([32768] * 7 + [4096] * 7, 4096), taken_in([32768] * 7, 4096)
    (7, 14, 0)
    """
    count, total = 0, max(new, SMALLEST)
    while True:
        level = size_class(total)
        if count < len(sizes) and size_class(sizes[-1 - count]) < level:
            total += max(sizes[-1 - count], SMALLEST)
            count += 1
            continue
        if level == LAST:
            return count
        together, run = total, count
        while run < len(sizes) and size_class(sizes[-1 - run]) <= level:
            together += max(sizes[-1 - run], SMALLEST)
            run += 1
        if run == count or together < SMALLEST * FACTOR ** (level + 1):
            return count
        count, total = run, together
