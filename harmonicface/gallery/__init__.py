"""The gallery: enrol people, match photographs."""
