"""Recognize faces under any lighting, and measure light and shape, with harmonic subspaces."""
