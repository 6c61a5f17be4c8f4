"""Records as a table: the same rows in a terminal, in Markdown and on a page."""

from __future__ import annotations

from collections.abc import Sequence

from harmonicface.bench.console import print_table
from harmonicface.bench.measure import Record
from harmonicface.bench.spelling import spelled_bytes, spelled_error, spelled_seconds, three_figures

TEXTS = ("what", "of what", "in", "beside", "note")  # columns of words, which may be broken
Table = tuple[list[str], list[list[str]]]


def record_table(records: Sequence[Record]) -> Table:
    """Return heads and rows; columns that no record fills are left out.

    Examples
    --------
    >>> record_table([Record("match one photo", "9 people", 0.002, peer="numpy.dot", peer_seconds=0.001)])
    (['#', 'what', 'of what', 'time', 'beside', 'its time', 'ratio'],
     [['1', 'match one photo', '9 people', '2 ms', 'numpy.dot', '1 ms', '2']])
    """
    columns = {
        "#": [str(number) for number in range(1, len(records) + 1)],
        "what": [record.name for record in records],
        "of what": [record.size for record in records],
        "time": [spelled_seconds(record.seconds) for record in records],
        "error": [spelled_error(record.error) for record in records],
        "in": [record.unit for record in records],
        "memory": [spelled_bytes(record.bytes) for record in records],
        "beside": [record.peer or "" for record in records],
        "its time": [spelled_seconds(record.peer_seconds) for record in records],
        "its error": [spelled_error(record.peer_error) for record in records],
        "ratio": ["" if record.ratio is None else three_figures(record.ratio) for record in records],
        "seed": ["" if record.seed is None else str(record.seed) for record in records],
        "note": [record.note for record in records],
    }
    filled = {head: cells for head, cells in columns.items() if any(cells)}
    return list(filled), [list(row) for row in zip(*filled.values(), strict=True)]


def print_records(records: Sequence[Record], title: str = "") -> None:
    """Print records as a table on standard output, notes below it."""
    heads, rows = record_table(records)
    if "note" in heads:
        place = heads.index("note")
        heads, notes = heads[:place] + heads[place + 1 :], [row[place] for row in rows]
        rows = [row[:place] + row[place + 1 :] for row in rows]
    else:
        notes = []
    print_table(title, heads, rows, TEXTS)
    for number, note in enumerate(notes, start=1):
        if note:
            print(f"{number:>3}  {note}")


def markdown(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    r"""Return a table in Markdown, words to the left and numbers to the right.

    Examples
    --------
    >>> print(markdown(["what", "time"], [["a|b", "1 s"]]))
    | what | time |
    |---|--:|
    | a\|b | 1 s |
    """
    rule = "|".join("---" if head in TEXTS else "--:" for head in heads)
    lines = [" | ".join(_safe(cell) for cell in row) for row in (heads, *rows)]
    return "\n".join([f"| {lines[0]} |", f"|{rule}|", *(f"| {line} |" for line in lines[1:])])


def _safe(cell: str) -> str:
    """Return a cell that does not end before its end."""
    return cell.replace("|", "\\|").replace("\n", " ").replace("<", "&lt;")
