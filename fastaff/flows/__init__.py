"""From options to a running flow: checks, the choice of scheme and step, integration of many orbits, observers."""
