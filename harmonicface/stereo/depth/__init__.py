"""Normals -> depth."""
