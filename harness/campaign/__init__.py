"""Many stops over one pool of processes: campaigns, sweeps, repeats, and searches; each result kept as one value."""
