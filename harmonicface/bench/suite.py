"""Every benchmark, each in a process of its own; one that fails does not stop the others."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from harmonicface.bench.measure import Record, read_records
from harmonicface.errors import HarmonicFaceError

State = Literal["done", "skipped", "failed"]
TAIL = 12  # lines of what a failed benchmark said
SKIPPED = "skipped:"


@dataclass(frozen=True)
class Ran:
    """What became of a benchmark.

    Parameters
    ----------
    name
        Of its file, without the ending.
    question
        The first line of its docstring.
    about
        The rest, paragraphs apart by empty lines.
    state
        "done"; "skipped", as its data is not there; "failed".
    quick
        Whether it was run with --quick.
    seconds
        Wall time of the process.
    records
        What it measured.
    said
        Why it was skipped, in whole or in part, or the last lines of one that failed.
    """

    name: str
    question: str
    about: str
    state: State
    quick: bool
    seconds: float
    records: tuple[Record, ...] = ()
    said: str = ""


def benchmarks_in(folder: str | os.PathLike[str], names: Sequence[str] = ()) -> list[Path]:
    """Return the files of a folder, all or those that are named, by name.

    Raises
    ------
    HarmonicFaceError
        No benchmark has such a name, or there are none at all.
    """
    files = {path.stem: path for path in sorted(Path(folder).glob("*.py"))}
    if not files:
        raise HarmonicFaceError(f"expected benchmarks in {folder}, got none")
    unknown = [name for name in names if name not in files]
    if unknown:
        raise HarmonicFaceError(f"benchmark: expected one of {', '.join(files)}, got {unknown[0]!r}")
    return [path for name, path in files.items() if not names or name in names]


def run_suite(
    files: Sequence[Path],
    out: str | os.PathLike[str],
    quick: Callable[[str], bool],
    limit: float,
    tell: Callable[[str], None] = lambda _: None,
) -> list[Ran]:
    """Run benchmarks one after the other; each writes its records to NAME.json in a folder.

    Parameters
    ----------
    files
        Of benchmarks, see `benchmarks_in`.
    out
        An existing folder.
    quick
        Says of a name whether it is run with --quick.
    limit
        Seconds after which a benchmark is ended, and has failed.
    tell
        Is told what is begun and what became of it.
    """
    found: list[Ran] = []
    start = time.perf_counter()
    for number, path in enumerate(files, start=1):
        way = "quick" if quick(path.stem) else "in full"
        tell(f"[{number:>2}/{len(files)}] {path.stem} ({way})")
        found.append(run_one(path, Path(out) / f"{path.stem}.json", quick(path.stem), limit))
        done = found[-1]
        what = f"{len(done.records)} records" if done.state == "done" else f"{done.state.upper()} {done.said}".strip()
        tell(f"        {what}; {done.seconds:.0f} s, {time.perf_counter() - start:.0f} s in all")
    return found


def run_one(path: Path, json: Path, quick: bool, limit: float) -> Ran:
    """Run one benchmark, and return what became of it."""
    question, _, about = described(path).partition("\n")
    json.unlink(missing_ok=True)
    command = [sys.executable, str(path), "--json", str(json), *(["--quick"] if quick else [])]
    start = time.perf_counter()
    code, said = _finished(command, limit)
    seconds = time.perf_counter() - start
    skipped = "\n".join(line for line in said.splitlines() if line.startswith(SKIPPED))

    def ran(state: State, text: str, records: Sequence[Record] = ()) -> Ran:
        return Ran(path.stem, question, about.strip(), state, quick, seconds, tuple(records), text)

    if code is None:
        return ran("failed", f"ended after {limit:.0f} s\n" + _tail(said))
    if code != 0:
        return ran("failed", _tail(said))
    if not json.exists():
        return ran("skipped", skipped) if skipped else ran("failed", "wrote no records\n" + _tail(said))
    try:
        return ran("done", skipped, read_records(json))
    except HarmonicFaceError as error:
        return ran("failed", str(error))


def described(path: Path) -> str:
    """Return the docstring of a file, or its name."""
    try:
        return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or path.stem
    except SyntaxError:  # what is wrong with it is said when it is run
        return path.stem


def _finished(command: Sequence[str], limit: float) -> tuple[int | None, str]:
    """Run a command and return its exit code and what it printed; None if it took too long and was ended."""
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as stream:
        process = subprocess.Popen(
            command, stdout=stream, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True
        )
        try:
            code: int | None = process.wait(limit)
        except BaseException as error:
            os.killpg(process.pid, signal.SIGKILL)  # with the processes that it has started
            process.wait()
            if not isinstance(error, subprocess.TimeoutExpired):
                raise
            code = None
        stream.seek(0)
        return code, stream.read()


def _tail(text: str) -> str:
    return "\n".join(text.strip().splitlines()[-TAIL:])
