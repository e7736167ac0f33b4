"""Loss of slope seeking over the ideal bound by its causes, and what knowledge of the rail would gain."""
