"""The one error that the package raises for bad input."""


class HarmonicFaceError(ValueError):
    """Bad input, told in one line: what was expected and what came.

    It derives from `ValueError`, so code that does not know the package catches it too.
    """
