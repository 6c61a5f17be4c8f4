from __future__ import annotations

import pytest

import harmonicface as hf


def test_who_does_not_know_the_package_catches_a_value_error() -> None:
    with pytest.raises(ValueError, match="expected"):
        hf.lights.ambient(-1)


def test_the_message_is_what_was_said() -> None:
    assert str(hf.HarmonicFaceError("expected this, got that")) == "expected this, got that"
