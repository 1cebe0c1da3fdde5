"""Wave packets, and when they come back."""
