"""A gallery on disk: what is in its folder, or in one file, what it takes, and whether it is whole."""
