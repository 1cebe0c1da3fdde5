"""Periodic orbits, their families and bifurcations."""
