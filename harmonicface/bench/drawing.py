"""What all plots share: their colours, and how a figure becomes a picture."""

from __future__ import annotations

import io

import matplotlib
from matplotlib.figure import Figure

matplotlib.use("Agg")

INK = "#22303c"
ACCENT = "#c8553d"  # ours
COOL = "#2f6f8f"
MUTED = "#8b97a2"

# methods that are not this package's own: peers in plots
BESIDE = ("correlation", "eigenfaces", "eigenfaces_minus3", "fisherfaces", "lbph", "tan_triggs", "gradient_angle")


def png(figure: Figure) -> bytes:
    """Return the PNG of a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    return buffer.getvalue()
