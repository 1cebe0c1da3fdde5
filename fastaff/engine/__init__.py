"""Compilation: the cache, and the text of the loops around methods of models, sections and angles. The only place with
code in strings.
"""

from .blocks import source

__all__ = ["source"]
