"""What a camera sees of a shape: normals, albedo, mask and depth on a pixel grid."""
