"""Symmetry classes, stationary states and the closed-form factors they are made of, tables of levels."""
