"""A small Modelica class with the values that its variables must have, and the library that holds many of them."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent
SHARED = (FOLDER / "Shared.mo").read_text()
"""Functions, records, enumerations and constants that cases use."""

Function = Callable[[float], float]
"""A value over time [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A class and its values.

    Attributes:
        name: What the case is about, unique.
        text: Body of a package, with the class `M`; it may use `Shared`.
        expected: Variable of M → value over time, computed without the compiler.
        tolerance: Largest error, relative to the largest expected value (or to one, if that is larger).
        may_be_refused: Whether the compiler may refuse it, with file and line; all others must be right.
    """

    name: str
    text: str
    expected: Mapping[str, Function]
    tolerance: float = 1e-5
    may_be_refused: bool = False


def paragraphs(file: str) -> Iterator[tuple[str, str]]:
    """Yield the comment and the text of each paragraph of a file of this folder; a comment alone is a heading."""
    for paragraph in (FOLDER / file).read_text(encoding="utf-8").split("\n\n"):
        comment, _, text = paragraph.strip().partition("\n")
        if text:
            yield comment.removeprefix("// "), text


def library(cases: Sequence[Case]) -> str:
    """Return the package `Corpus`, whose class `All` has each case as a component `c0`, `c1` and so on.

    A function or package of a case has the name `own`.
    """
    # rumoca confuses functions and packages of one name, so each has the number of its case.
    texts = [re.sub(r"\bown\b", f"own{k}", case.text.rstrip()) for k, case in enumerate(cases)]
    parts = [
        f'  package C{k} "{case.name}"\n{text}\n  end C{k};\n'
        for k, (case, text) in enumerate(zip(cases, texts, strict=True))
    ]
    components = "".join(f"    C{k}.M c{k};\n" for k in range(len(cases)))
    return f"package Corpus\n{SHARED}{''.join(parts)}  model All\n{components}  end All;\nend Corpus;\n"
