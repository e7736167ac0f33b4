"""Common foundation of all packages.

Errors, files, the cache, units, limits, signal handling, and the registry of parts.
"""
