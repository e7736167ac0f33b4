"""The one way a result is refused."""


class RecordError(ValueError):
    """A result file that is missing, unreadable or not one of ours; the text is for the user."""
