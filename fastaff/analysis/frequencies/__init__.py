"""Fundamental frequencies, resonances and their web."""
