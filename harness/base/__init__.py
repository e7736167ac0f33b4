"""What every package may use: errors, files, the cache, units, limits, signals to stop, and the registry of parts."""
