"""Chaos indicators, maps of verdicts, chaotic fractions."""
