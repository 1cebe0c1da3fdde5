"""Orbits and their tangent maps."""
