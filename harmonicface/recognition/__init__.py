"""Whose face is it: subspaces and the methods they are compared with."""
