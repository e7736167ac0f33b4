"""The rules of all chapters, from rules.mo.

The comment above a rule has its name, which begins with the section, and the values of its variables as formulas of the
time t: `// 8.5 pre; y = 1 if t < 0.3 else 2`. `// refused: ` before the name permits the compiler to refuse the rule,
`tolerance` is that of `Case`.
"""

import math

import numpy as np
from corpus import closed_forms
from corpus.case import Case, paragraphs

NAMES = {"math": math, "np": np} | vars(closed_forms)


def _rule(comment: str, text: str) -> Case:
    name, *parts = comment.split("; ")
    formulas = dict(part.split(" = ", 1) for part in parts)
    return Case(
        name=name.removeprefix("refused: "),
        text=text,
        may_be_refused=name.startswith("refused: "),
        tolerance=float(formulas.pop("tolerance", 1e-5)),
        expected={variable: eval(f"lambda t: {formula}", NAMES) for variable, formula in formulas.items()},
    )


RULES = [_rule(*paragraph) for paragraph in paragraphs("rules.mo")]
