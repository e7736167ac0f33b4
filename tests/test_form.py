"""Form of the code, as a ratchet: neither unidiomatic phrases nor class names with several meanings increase.

`form.toml` has the accepted numbers. Lower them when the code has fewer; they are never raised.
"""

import ast
import io
import re
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("harness", "estimators", "controllers", "fmus")
ACCEPTED = tomllib.loads(Path(__file__).with_name("form.toml").read_text(encoding="utf-8"))

PHRASES = {
    "is no X": r"\b(?:is|are|was|were) no [a-z]+\b(?! (?:longer|more|less))",
    "none as a predicate": r"\b(?:is|are|was|has) none\b",
    "Return what": r"\bReturn what\b",
    "what there is": r"\bwhat (?:there is|is|was|are|they|it)\b",
    "wants": r"\bwant(?:s|ed)\b",
    "most or least as a noun": r"\b(?:the|at) (?:most|least)\b(?! (?:one|two|\d))|\b(?:most|least) that\b",
    "tells": r"\b(?:tells?|told)\b",
    "stands": r"\bstands?\b(?!still)",
    "at the begin": r"\bat the begin\b",
    "of its own": r"\bof (?:ours|one's own|its own|their own|the user's own)\b",
    "believes": r"\bbeliev\w+",
    "beside": r"\bbeside\b",
    "lies": r"\b(?:laid|lies|lying)\b",
    "so many": r"\b(?:so much|so many|as little)\b",
}
"""Name → pattern of a phrase that a native engineer seldom writes."""


def sources(*endings: str, packages: Sequence[str] = PACKAGES) -> list[Path]:
    return sorted(path for package in packages for ending in endings for path in (ROOT / package).rglob(ending))


def docstrings(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        for statement in body if isinstance(body, list) else ():
            value = getattr(statement, "value", None)
            if isinstance(statement, ast.Expr) and isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value.value


def texts(packages: Sequence[str]) -> Iterator[str]:
    """Yield docstrings and comments of Python, and comments of C."""
    for path in sources("*.py", packages=packages):
        source = path.read_text(encoding="utf-8")
        yield from docstrings(ast.parse(source))
        tokens = tokenize.generate_tokens(io.StringIO(source).readline)
        yield from (token.string for token in tokens if token.type == tokenize.COMMENT)
    for path in sources("*.c", "*.h", packages=packages):
        yield from re.findall(r"/\*.*?\*/|//[^\n]*", path.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize(("packages", "accepted"), [(PACKAGES, "phrases"), (("tests",), "phrases_of_tests")])
def test_odd_phrases_do_not_increase(packages, accepted):
    found = (name for text in texts(packages) for name, pattern in PHRASES.items() for _ in re.finditer(pattern, text))
    counts = Counter(found)
    assert counts.total() <= ACCEPTED[accepted], dict(counts)


def test_class_names_with_several_meanings_do_not_increase():
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sources("*.py"))
    classes = [n.name.lstrip("_") for n in chain(*map(ast.walk, trees)) if isinstance(n, ast.ClassDef)]
    several = {name: count for name, count in Counter(classes).items() if count > 1}
    assert len(several) <= ACCEPTED["class_names"], several


@pytest.mark.parametrize("name", PHRASES)
def test_each_pattern_finds_its_phrase(name):
    examples = (
        "It is no train. There are none; that is none. Return what it was. He wants the most that he tells. It stands "
        "at the begin of its own, believes beside what lies, so many."
    )
    assert re.search(PHRASES[name], examples)
