"""Levels of a symmetry class, of the whole body, against a parameter."""
