"""Unknown distant lamps: their directions and the normals, up to what photographs leave open."""
