"""Foundations of the package: statuses, checks of numbers and arrays, the display of results, the record of calls."""
