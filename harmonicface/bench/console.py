"""The terminal: bars while work goes on, tables when it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

WIDE = 180  # columns of what is no terminal


@contextmanager
def progress() -> Iterator[Callable[[str, int, int], None]]:
    """Show bars on standard error, one for each thing that is done; call with what, how much, of how much."""
    columns = TextColumn("{task.description:>28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    bar = Progress(*columns, console=Console(stderr=True))
    tasks: dict[str, TaskID] = {}

    def tell(what: str, done: int, of: int) -> None:
        bar.start()
        if what not in tasks:
            tasks[what] = bar.add_task(what, total=of)
        bar.update(tasks[what], completed=done)

    try:
        yield tell
    finally:
        if tasks:  # stopping a bar prints a line even if nothing was shown
            bar.stop()


@contextmanager
def waiting(what: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal's standard error what is being done; call with what comes next."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status(f"{what} ...") as status:
        yield lambda following: status.update(f"{following} ...")


def print_table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], texts: Sequence[str] = ()) -> None:
    """Print a table: the first column and texts to the left, numbers to the right; texts alone are broken.

    It fits a terminal, and what is no terminal is as wide as it takes.
    """
    table = Table(
        title=title or None,
        title_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for index, head in enumerate(heads):
        left = head in texts if texts else index == 0
        broken = head in texts
        table.add_column(
            head, justify="left" if left else "right", no_wrap=not broken, overflow="fold" if broken else "ellipsis"
        )
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console = Console()
    if texts and not console.is_terminal:
        console = Console(width=WIDE)
    console.print(table)
