from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from harmonicface import _memory
from harmonicface._memory import physical_memory
from harmonicface.errors import HarmonicFaceError


@pytest.fixture(autouse=True)
def ask_the_system_again() -> Iterator[None]:
    physical_memory.cache_clear()
    yield
    physical_memory.cache_clear()


def test_what_fits_is_let_through() -> None:
    _memory.require(10**6, "a megabyte")
    assert _memory.empty((2, 3), np.float32, "six numbers").shape == (2, 3)


def test_what_does_not_fit_says_how_much_it_takes_and_how_much_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_memory, "physical_memory", lambda: 8 * 10**9)
    with pytest.raises(
        HarmonicFaceError, match=r"^a cake: need 9.5 GB of memory, expected at most the 8 GB there are$"
    ):
        _memory.require(9_500_000_000, "a cake")
    with pytest.raises(HarmonicFaceError, match=r"^a cake: need 16 GB of memory"):
        _memory.empty((2 * 10**9,), np.float64, "a cake")


def test_a_system_that_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(np, "empty", refuse)
    with pytest.raises(HarmonicFaceError, match=r"^a cake: need 4e-08 GB of memory, the system refused them$"):
        _memory.empty((5,), np.float64, "a cake")


def test_a_container_may_hold_less_than_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit = tmp_path / "memory.max"
    monkeypatch.setattr(_memory, "CONTAINER_LIMIT", limit)
    machine = physical_memory()
    limit.write_text("123456\n")
    physical_memory.cache_clear()
    assert physical_memory() == 123456
    limit.write_text("max\n")
    physical_memory.cache_clear()
    assert physical_memory() == machine


def test_a_system_that_does_not_tell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_memory, "CONTAINER_LIMIT", tmp_path / "nothing")
    monkeypatch.delattr(os, "sysconf")
    assert physical_memory() == 2**63 - 1
