"""What is said of wrong input of a job or a command."""

from __future__ import annotations


class Wrong(ValueError):
    """Wrong input: its text is all that the user sees."""
