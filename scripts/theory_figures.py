"""Draw the figures of docs/theory.md: python scripts/theory_figures.py docs/theory."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import harmonicface as hf
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.io.files import replacing
from harmonicface.io.pictures import signed_colours, to_display
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter

INK, ACCENT = "#22303c", "#c8553d"
NAMES = ("1", "y", "z", "x", "xy", "yz", "3z²-1", "xz", "x²-y²")


def ball(size: int = 128) -> hf.Surface:
    """Return a white ball, which shows a function of the normal."""
    across = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(across, -across)
    squared = 1 - x**2 - y**2
    return hf.Surface(np.dstack([x, y, np.sqrt(np.maximum(squared, 0))]), np.ones((size, size)), squared > 0)


def nine_harmonics() -> Figure:
    """Draw the nine harmonics of order 2 on a ball."""
    white = ball()
    figure = Figure(figsize=(9, 1.3), layout="constrained")
    values = real_harmonics(white.pixel_normals, 2)
    for axis, row, name in zip(figure.subplots(1, 9), values, NAMES, strict=True):
        picture = np.zeros(white.shape)
        picture[white.mask] = row
        axis.imshow(signed_colours(picture, white.mask, 0.9))
        axis.set_title(name, fontsize=10, color=INK)
        axis.axis("off")
    return figure


def clamped_cosine() -> Figure:
    """Draw the clamped cosine by orders, and the filters of matte and glossy surfaces."""
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    angle = np.linspace(0, np.pi, 400)
    directions = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    left.plot(np.degrees(angle), np.maximum(np.cos(angle), 0), color=INK, lw=2, label="exact")
    for order, style in ((1, ":"), (2, "-"), (4, "--")):
        lamp = hf.lights.directional([0, 0, 1])
        approximate = hf.HarmonicLight(lamp.coefficients(order)).irradiance(directions)
        left.plot(np.degrees(angle), approximate, style, color=ACCENT, label=f"order {order}")
    left.set_xlabel("angle between normal and lamp, degrees")
    left.set_ylabel("irradiance")
    left.legend(frameon=False)
    most = 20
    matte = np.abs(lambertian_filter(most)) / np.pi
    shown = matte > 0
    right.semilogy(np.arange(most + 1)[shown], matte[shown], "o-", color=ACCENT, label="matte |A_l| / π")
    for shininess, style in ((8.5, ":"), (64.5, "--")):
        glossy = np.abs(phong_filter(shininess, most))
        right.semilogy(glossy / glossy[0], style, color=INK, label=f"Phong, shininess {shininess:g}")
    right.set_ylim(1e-6, 2)
    right.set_xlabel("degree l")
    right.set_ylabel("share of the light's degree l that is seen")
    right.legend(frameon=False, loc="lower left")
    for axis in (left, right):
        axis.spines[["top", "right"]].set_visible(False)
    return figure


def irradiance() -> Figure:
    """Draw an environment, the ball it lights, exactly and by nine numbers, and the difference."""
    sky = hf.lights.natural(seed=11, size=64)
    white = ball()
    exact, nine = hf.render(white, sky), hf.render(white, sky, order=2)
    figure = Figure(figsize=(9, 2.3), layout="constrained")
    axes = figure.subplots(1, 4, width_ratios=(2, 1, 1, 1))
    axes[0].imshow(to_display(sky.radiance), cmap="gray")
    axes[1].imshow(to_display(exact), cmap="gray")
    axes[2].imshow(to_display(np.clip(nine, 0, None)), cmap="gray")
    scale = 0.1 * float(exact.max())
    axes[3].imshow(signed_colours(nine - exact, white.mask, scale))
    titles = ("light from everywhere", "2 x 64 x 64 directions", "9 numbers", "difference, up to 10 %")
    for axis, title in zip(axes, titles, strict=True):
        axis.set_title(title, fontsize=10, color=INK)
        axis.axis("off")
    return figure


def conditioning() -> Figure:
    """Draw what each degree of the light costs to recover from a matte ball."""
    figure = Figure(figsize=(5.4, 3), layout="constrained")
    axis = figure.subplots()
    per_mode = lambertian_filter(8)[degrees(8)]
    gain = np.full(9, np.inf)
    for degree in range(9):
        strength = np.abs(per_mode[degrees(8) == degree]).max()
        gain[degree] = np.pi / strength if strength else np.inf
    finite = np.isfinite(gain)
    axis.bar(np.arange(9)[finite], gain[finite], color=INK)
    for degree in np.flatnonzero(~finite):
        axis.text(degree, 1.3, "lost", ha="center", color=ACCENT)
    axis.set_yscale("log")
    axis.set_xlabel("degree l of the light")
    axis.set_ylabel("noise gain (l = 0 is 1)")
    axis.spines[["top", "right"]].set_visible(False)
    return figure


def main() -> None:
    """Write all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="where the pictures go")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for draw in (nine_harmonics, clamped_cosine, irradiance, conditioning):
        with replacing(folder / f"{draw.__name__}.png") as temporary:
            draw().savefig(temporary, dpi=110, format="png")


if __name__ == "__main__":
    main()
