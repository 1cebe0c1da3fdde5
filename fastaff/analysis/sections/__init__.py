"""Energy surfaces, Poincaré maps, rotation numbers and islands."""
