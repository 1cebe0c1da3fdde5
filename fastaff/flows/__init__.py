"""From options to a running flow: checks, the choice of scheme and step, integration of many orbits, observers."""

from .flow import Flow
from .observers import Observer
from .options import Options, Plan, plan

__all__ = ["Flow", "Observer", "Options", "Plan", "plan"]
