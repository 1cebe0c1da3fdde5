"""Periodic orbits, their families and bifurcations."""

from .bifurcations import Bifurcation, Event
from .continuation import Branch
from .find_periodic_orbits import periodic_guesses
from .found_orbits import PeriodicOrbits, Stability

__all__ = ["Bifurcation", "Branch", "Event", "PeriodicOrbits", "Stability", "periodic_guesses"]
