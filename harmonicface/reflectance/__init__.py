"""Materials: how a surface filters the light that falls on it."""
