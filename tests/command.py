"""How tests run the command, and what it says."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

import pytest

from harmonicface.cli import main


class Answer(NamedTuple):
    """The exit code, and what stands on standard output and on standard error."""

    code: int
    out: str
    err: str


Run = Callable[..., Answer]


def runner(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *command: str) -> Run:
    """Return what runs harmonicface, or one of its commands, with arguments."""

    def called(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["harmonicface", *command, *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as leaving:
            main()
        said = capsys.readouterr()
        return Answer(int(leaving.value.code or 0), said.out, said.err)

    return called
