"""Eigenvalue problems of bodies that separate and of those that do not."""
