"""Surface x light: harmonic images, rendering, the camera's noise."""
