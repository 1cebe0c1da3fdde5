"""What results of all analyses can do: axes, display, the call that made them, progress of the call."""
