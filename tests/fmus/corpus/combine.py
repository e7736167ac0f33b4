"""All combinations of features and contexts as cases."""

import re

from corpus.case import Case
from corpus.contexts import CONTEXTS, SIGNALS, THRESHOLD, VALUE
from corpus.exceptions import may_be_refused
from corpus.features import FEATURES


def combine(feature: str, context: str) -> Case | None:
    """Return the case of a feature in a context, or None where its derivative does not exist."""
    expression, place = FEATURES[feature], CONTEXTS[context]
    if place.smooth and not expression.smooth:
        return None
    text, signal = SIGNALS[expression.domain]
    value = VALUE[expression.domain]

    def inserted(match: re.Match[str]) -> str:
        return re.sub(r"\bu\b", match[1], expression.text)

    body = re.sub(r"\bE\(([^()]*)\)", inserted, place.text)
    body = re.sub(r"\bSIGNAL_OF\((\w+)\)", lambda m: text.replace("time", m[1]), body)
    body = body.replace("SIGNAL", text).replace("VALUE", str(value)).replace("THRESHOLD", str(THRESHOLD))
    return Case(
        name=f"{feature} | {context}",
        text=body,
        expected={"y": place.expected(expression.formula, signal, value)},
        tolerance=place.tolerance,
        may_be_refused=may_be_refused(feature, context),
    )


def combinations() -> list[Case]:
    """Return all combinations, those of a context next to each other."""
    every = [combine(feature, context) for context in CONTEXTS for feature in FEATURES]
    return [case for case in every if case is not None]


def sample() -> list[Case]:
    """Return each feature in one context, such that each context has a feature."""
    contexts = list(CONTEXTS)
    found: list[Case] = []
    turn = 0
    for feature in FEATURES:
        case = None
        while case is None:
            case = combine(feature, contexts[turn % len(contexts)])
            turn += 1
        found.append(case)
    return found
