"""The names that the README and the design promise."""

from __future__ import annotations

from importlib.metadata import version

import harmonicface as hf


def test_every_promised_name_is_there_and_documented() -> None:
    for name in hf.__all__:
        assert getattr(hf, name).__doc__, name
    assert len(set(hf.__all__)) == len(hf.__all__)


def test_the_calls_of_the_design_have_their_names() -> None:
    promised = {"load_surface", "Surface", "harmonic_images", "render", "EnvironmentMap", "Gallery", "verify"}
    assert promised <= set(hf.__all__)
    assert {"directional", "from_angles", "ambient", "natural"} <= set(hf.lights.__all__)


def test_the_version_is_that_of_the_installed_package() -> None:
    assert hf.__version__ == version("harmonicface")
