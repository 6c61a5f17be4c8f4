"""Unknown light of any kind: the harmonics of one field of normals, found in the photographs' factors."""
