"""Known lights: photographs -> normals and albedo."""
