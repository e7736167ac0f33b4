"""The one way a scenario, campaign or override is refused."""


class ScenarioError(ValueError):
    """A question that cannot be run; its text is for the user: file, table and key, found, wanted.

    Several problems of one file are one error of several lines, a sentence each.
    """
