"""Poincaré maps and frequency maps of planar affinely-rigid bodies."""
