"""Wave packets and their revivals."""
