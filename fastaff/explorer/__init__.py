"""The explorer: a page of its own that shows a section; a click on it launches an orbit."""
