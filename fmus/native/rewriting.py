"""Forms of Modelica that the front end does not read, rewritten into others of the same meaning.

The front end reads a class as it is written first; only if that fails, the texts are rewritten and read again:

- An algorithm section of a model becomes equations: its statements are executed in order on expressions, with loops
  unrolled (11.1). A Real variable that is read before it is assigned has its start value (11.1.2).
- A for equation over a list, over Real numbers or without a range is unrolled (8.3.2, 11.2.2); an iterator without a
  range in an array or reduction is given its range (10.3.4.1), a reduction over a list becomes one of an array, and a
  constructor with several iterators becomes nested ones (10.4.1).
- Elements of an array that a when equation assigns one by one, also in for equations inside or around it, become one
  equation of the array (8.3.5).
- An if equation of assertions becomes assertions that hold where the branch is not active (8.3.4).
- A modifier with a dotted name is written with brackets (7.2).

If it also fails on an empty array, whose type it does not know, arrays and reductions over ranges get one element more,
which a slice removes: their range may be empty (10.3.4, 10.4.1).

What is not certain to keep its meaning stays as it is, and is refused as before. Rewritten texts keep their lines.
"""

import contextlib
import re
from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from math import ceil, floor
from typing import Any

from railgrip.base.errors import RewritingError
from railgrip.fmus.native.library import CLASS_PREFIXES, CLASS_WORDS

_TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|\s+|(?P<token>"(?:[^"\\]|\\.)*"|\.?(?:[^\W\d]\w*|'(?:[^'\\]|\\.)*')"""
    r"""(?:\.(?:[^\W\d]\w*|'(?:[^'\\]|\\.)*'))*|\d+(?:\.\d+|\.(?![*/+^\-]))?(?:[eE][+-]?\d+)?|:=|==|<>|<=|>="""
    r"""|\.[*/+^\-]|.)""",
    re.DOTALL,
)
_NAME = re.compile(r"\.?[^\W\d][\w.]*")
_ACCESS = frozenset(["public", "protected"])
_VARIABILITIES = frozenset(["parameter", "constant", "discrete", "input", "output", "flow", "stream"])
_SECTIONS = frozenset(["equation", "algorithm"])
_WORDS = frozenset(
    ["if", "then", "else", "elseif", "for", "in", "loop", "and", "or", "not", "true", "false", "end", "initial"]
)
_ELEMENT = re.compile(r"([^\W\d]\w*) \[\s*([\d\s,]+?)\s*\] = (.*)", re.DOTALL)
"""An equation of an element of an array."""
_LONG = 200
"""Characters of an expression from which on it has a name."""
_LONGEST = 10_000
"""Longest expression, in characters, and largest number of statements of an unrolled section."""


_Piece = tuple[int, str]
"""Line and text of an equation."""

_Edit = tuple[int, int, str]
"""Begin and end of a part of a text, and what replaces it."""


@dataclass(frozen=True, slots=True)
class _Token:
    text: str
    start: int
    end: int
    line: int


@dataclass(frozen=True, slots=True)
class _Declaration:
    """A declared variable: its type, its prefixes, the tokens of its sizes, and of all that follows its name."""

    type: str
    prefixes: frozenset[str]
    sizes: tuple[tuple[_Token, ...], ...]
    rest: tuple[_Token, ...]

    @property
    def has_known_value(self) -> bool:
        """Whether the value is compiled in: that of a constant, or of an Integer parameter."""
        return "constant" in self.prefixes or ("parameter" in self.prefixes and self.type == "Integer")


@dataclass(slots=True)
class _Scope:
    """A class: its kind, variables of it and the classes around it, and its sections: keyword, first token, end."""

    kind: str
    name: str = ""
    is_short: bool = False
    variables: ChainMap[str, _Declaration] = field(default_factory=ChainMap[str, _Declaration])
    sections: list[tuple[str, int, int]] = field(default_factory=list[tuple[str, int, int]])


@dataclass(frozen=True, slots=True)
class _Clause:
    """A statement or equation.

    Attributes:
        kind: "if", "for", "when", or "" for any other.
        branches: Condition (of an else: none) and statements of each branch; of a for, its only one.
        iterators: Name of each iterator → tokens of its range, if any.
        tokens: All of its tokens without the semicolon.
    """

    kind: str
    tokens: tuple[_Token, ...]
    branches: "tuple[_Branch, ...]" = ()
    iterators: tuple[tuple[str, tuple[_Token, ...]], ...] = ()


_Branch = tuple[tuple[_Token, ...], tuple[_Clause, ...]]
"""Condition and statements."""


def rewrite(texts: Mapping[str, str], *, has_empty_ranges: bool = False) -> dict[str, str]:
    """Return the texts of Modelica files that are rewritten, by name.

    Args:
        texts: All files of the libraries that are read, by name: a modifier in any of them may change a start value.
        has_empty_ranges: Whether the range of an array or reduction may be empty.
    """
    every = "\n".join(texts.values())
    changed = {name: _rewrite(text, every) for name, text in texts.items()}
    if has_empty_ranges:
        changed = {name: _with_first_elements(text) for name, text in changed.items()}
    return {name: text for name, text in changed.items() if text != texts[name]}


def _rewrite(text: str, every: str) -> str:
    text = _edited(text, _in_brackets(_tokens(text)))
    tokens, edits = _tokens(text), list[_Edit]()
    for scope in _scopes(tokens):
        for keyword, first, end in scope.sections:
            with contextlib.suppress(RewritingError, IndexError):
                edits += _section(scope, keyword, tokens[first - 1 : end], every)
    return _edited(text, edits)


def _edited(text: str, edits: Iterable[_Edit]) -> str:
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _tokens(text: str) -> list[_Token]:
    found: list[_Token] = []
    line, last = 1, 0
    for match in _TOKEN.finditer(text):
        if match["token"]:
            line, last = line + text.count("\n", last, match.start()), match.start()
            found.append(_Token(match[0], match.start(), match.end(), line))
    return found


# Classes, declarations and statements


def _scopes(tokens: Sequence[_Token]) -> list[_Scope]:
    stack, found = [_Scope("")], list[_Scope]()
    depth, begin, section, i = 0, 0, "", 0

    def close() -> None:
        nonlocal section
        if section:
            stack[-1].sections.append((section, begin, i))
        section = ""

    while i < len(tokens):
        word = tokens[i].text
        depth += (word in "([{") - (word in ")]}")
        if depth:
            i += 1
            continue
        previous = tokens[i - 1].text if i else ""
        if word in CLASS_WORDS and previous != "end":
            close()
            kind = word
            while tokens[i + 1].text in (*CLASS_WORDS, "extends"):
                i += 1
                kind = tokens[i].text if tokens[i].text in CLASS_WORDS else kind
            i += 1
            is_short, around = tokens[i + 1].text == "=", stack[-1].variables
            stack.append(_Scope(kind, tokens[i].text, is_short=is_short, variables=around.new_child()))
            begin = i + 1
        elif word == "end" and tokens[i + 1].text == stack[-1].name:
            close()
            found.append(stack.pop())
            i += 2
            begin = i + 1
        elif word in _SECTIONS:
            close()
            section = f"initial {word}" if previous == "initial" else word
            begin = i + 1
        elif (
            section
            and word in ("initial", "public", "protected", "annotation", "external")
            and previous in (";", section)
        ):
            close()
            begin = i
        elif word == ";":
            if stack[-1].is_short:
                found.append(stack.pop())
                begin = i + 1
            elif not section:
                _declare(stack[-1], tokens[begin:i])
                begin = i + 1
        i += 1
    return found


def _declare(scope: _Scope, tokens: Sequence[_Token]) -> None:
    words = [token.text for token in tokens]
    k = 0
    # The description of the class precedes its first declaration.
    while k < len(words) and (words[k] in CLASS_PREFIXES | _ACCESS | _VARIABILITIES or words[k][0] in '"+'):
        k += 1
    prefixes, rest = frozenset(words[:k]), tokens[k:]
    if len(rest) < 2 or rest[0].text in ("import", "extends", "annotation", "external", "end"):
        return
    type_, rest = rest[0].text, rest[1:]
    before, rest = _subscripts(rest)
    for part in _split(rest):
        sizes, after = _subscripts(part[1:])
        if part and _NAME.fullmatch(part[0].text):
            scope.variables[part[0].text] = _Declaration(type_, prefixes, (*sizes, *before), tuple(after))


def _subscripts(tokens: Sequence[_Token]) -> tuple[tuple[tuple[_Token, ...], ...], Sequence[_Token]]:
    # The subscripts at the beginning, and the tokens after them.
    if not tokens or tokens[0].text != "[":
        return (), tokens
    end = _closing(tokens, 0)
    return tuple(map(tuple, _split(tokens[1:end]))), tokens[end + 1 :]


def _closing(tokens: Sequence[_Token], k: int) -> int:
    depth = 0
    for i in range(k, len(tokens)):
        depth += (tokens[i].text in "([{") - (tokens[i].text in ")]}")
        if depth == 0:
            return i
    raise RewritingError


def _split(tokens: Sequence[_Token], separator: str = ",") -> list[Sequence[_Token]]:
    depth, parts, begin = 0, list[Sequence[_Token]](), 0
    for i, token in enumerate(tokens):
        depth += (token.text in "([{") - (token.text in ")]}")
        if token.text == separator and not depth:
            parts.append(tokens[begin:i])
            begin = i + 1
    return [*parts, tokens[begin:]] if tokens else []


class _Parser:
    """The statements of a section."""

    def __init__(self, tokens: Sequence[_Token]) -> None:
        self.tokens, self.i = tokens, 0

    def statements(self, *ends: str) -> tuple[_Clause, ...]:
        found: list[_Clause] = []
        while self.i < len(self.tokens) and self.tokens[self.i].text not in ends:
            found.append(self._statement())
        return tuple(found)

    def _statement(self) -> _Clause:
        begin, word = self.i, self.tokens[self.i].text
        branches: tuple[_Branch, ...] = ()
        iterators: tuple[tuple[str, tuple[_Token, ...]], ...] = ()
        if word in ("if", "when"):
            branches = self._branches()
        elif word == "for":
            self.i += 1
            iterators = _iterators(self._until("loop"))
            branches = (((), self.statements("end")),)
        else:
            return _Clause("", (*self._until(";"),))
        if [token.text for token in self.tokens[self.i : self.i + 3]] != ["end", word, ";"]:
            raise RewritingError
        self.i += 3
        return _Clause(word if branches else "", tuple(self.tokens[begin : self.i]), branches, iterators)

    def _branches(self) -> tuple[_Branch, ...]:
        found: list[_Branch] = []
        while self.tokens[self.i].text != "end":
            has_condition = self.tokens[self.i].text != "else"
            self.i += 1
            condition = tuple(self._until("then")) if has_condition else ()
            found.append((condition, self.statements("elseif", "elsewhen", "else", "end")))
        return tuple(found)

    def _until(self, word: str) -> Sequence[_Token]:
        begin, depth = self.i, 0
        while depth or self.tokens[self.i].text != word:
            text = self.tokens[self.i].text
            # An if expression in a condition has a `then` of its own.
            depth += (text in "([{") - (text in ")]}")
            if text == "if" and word == "then":
                raise RewritingError
            self.i += 1
        self.i += 1
        return self.tokens[begin : self.i - 1]


def _iterators(tokens: Sequence[_Token]) -> tuple[tuple[str, tuple[_Token, ...]], ...]:
    found: list[tuple[str, tuple[_Token, ...]]] = []
    for part in _split(tokens):
        if not part or not _NAME.fullmatch(part[0].text) or (len(part) > 1 and part[1].text != "in"):
            raise RewritingError
        found.append((part[0].text, tuple(part[2:])))
    return tuple(found)


# Numbers that are known


_FUNCTIONS: Mapping[str, Any] = {
    "integer": floor, "floor": floor, "ceil": ceil, "abs": abs, "min": min, "max": max,
    "mod": lambda x, y: x - floor(x / y) * y, "rem": lambda x, y: x - int(x / y) * y, "div": lambda x, y: int(x / y),
}  # fmt: skip


def _number(text: str) -> float | None:
    # The value of an expression of numbers, None for any other.
    words = [match["token"] for match in _TOKEN.finditer(text) if match["token"]]
    if not words or not all(re.fullmatch(r"[\d.]+(?:[eE][+-]?\d+)?|[-+*/(),]", w) or w in _FUNCTIONS for w in words):
        return None
    try:
        value = eval(" ".join(words), {"__builtins__": {}}, dict(_FUNCTIONS))
    except (ArithmeticError, SyntaxError, TypeError, ValueError):
        return None
    return value if isinstance(value, int | float) else None


# Sections


def _section(scope: _Scope, keyword: str, tokens: Sequence[_Token], every: str) -> Iterator[_Edit]:
    word, *tokens = tokens
    if keyword.startswith("initial") or scope.kind == "function" or not tokens:
        return
    statements = _Parser(tokens).statements()
    if keyword == "equation":
        for statement in statements:
            writer = _Unroller(scope, every)
            with contextlib.suppress(RewritingError):
                if writer.must_change([statement]):
                    begin, end = statement.tokens[0], statement.tokens[-1]
                    yield begin.start, end.end, _on_lines(writer.equations([statement], {}), begin.line, end.line)
        return
    last: dict[tuple[str, str], int] = {}
    _Execution(scope, every, last, is_trial=True).run(statements)
    execution = _Execution(scope, every, last, is_trial=False)
    execution.run(statements)
    equations = _on_lines(execution.written, word.line, tokens[-1].line)
    yield word.start, tokens[-1].end, f"{''.join(execution.declared)}equation{equations}"


def _on_lines(pieces: Iterable[_Piece], first: int, last: int) -> str:
    text, line = "", first
    for number, piece in sorted(pieces, key=lambda item: item[0]):
        text += "\n" * (number - line) + f" {piece};"
        line = max(line, number) + piece.count("\n")
    return text + "\n" * (last - line)


def _listed(range_: Sequence[_Token]) -> list[Sequence[_Token]]:
    # The elements of an array constructor of numbers or calls; a variable could be an array, which no iterator is.
    parts = _split(range_[1:-1])
    is_variable = [len(part) == 1 and _NAME.fullmatch(part[0].text) and "." not in part[0].text for part in parts]
    words = {token.text for token in range_[1:-1]}
    if _closing(range_, 0) != len(range_) - 1 or words & {"for", "{", "["} or any(is_variable):
        raise RewritingError
    return parts


def _place_of(iterator: str, tokens: Sequence[_Token]) -> tuple[_Token, int] | None:
    # The first variable that an iterator is a subscript of, and the place of the subscript (10.3.4.1).
    for k, token in enumerate(tokens[:-1]):
        if _NAME.fullmatch(token.text) and token.text not in _WORDS and tokens[k + 1].text == "[":
            for place, part in enumerate(_split(tokens[k + 2 : _closing(tokens, k + 1)])):
                if [t.text for t in part] == [iterator]:
                    return token, place
    return None


class _Unroller:
    """Equations with iterators replaced by their values."""

    def __init__(self, scope: _Scope, every: str) -> None:
        self.scope, self.every = scope, every
        self.count = 0
        self.names = frozenset[str]()  # variables that an algorithm assigns

    def must_change(self, statements: Iterable[_Clause]) -> bool:
        return any(
            _is_assertion(s)
            if s.kind == "if"
            else (
                s.kind == "for"
                and not all(r and not any(re.match(r"\{|\d+\D", t.text) for t in r) for _, r in s.iterators)
            )
            or (
                s.kind == "when"
                and len(s.branches) == 1
                and any(e.tokens[1].text == "[" or e.kind == "for" for e in s.branches[0][1])
            )
            or any(self.must_change(body) for _, body in s.branches)
            for s in statements
        )

    def equations(
        self,
        statements: Iterable[_Clause],
        values: Mapping[str, str],
        guard: Callable[[str], str] | None = None,
        *,
        unrolls: bool = False,
    ) -> list[_Piece]:
        # In an if equation, which has assertions only, each is under the guard of its branch.
        pieces = list[_Piece]()
        for statement in statements:
            line, tokens = statement.tokens[0].line, statement.tokens
            if guard and not statement.kind:
                pieces.append((line, self.assertion(tokens, values, guard)))
            elif not (statement.kind == "for" and unrolls) and not self.must_change([statement]):
                pieces.append((line, self.text(tokens, values).removesuffix(";").strip()))
            elif statement.kind == "for":
                body = statement.branches[0][1]
                clauses = [s for s in body if s.kind == "when" and self.must_change([s])]
                for inside in self.points(statement, values):
                    pieces += self.equations([s for s in body if s not in clauses], inside, unrolls=unrolls)
                for clause in clauses:
                    ((condition, inner),) = clause.branches
                    if {t.text for t in condition} & {name for name, _ in statement.iterators}:
                        raise RewritingError
                    around = replace(statement, branches=(((), inner),))
                    pieces.append((line, self._when(replace(clause, branches=((condition, (around,)),)), values)))
            elif statement.kind == "when":
                pieces.append((line, self._when(statement, values)))
            else:
                before = list[str]()
                for words, body in statement.branches:
                    condition = self.text(words, values)
                    pieces += self.equations(body, values, _guarded(guard or str, tuple(before), condition))
                    before.append(condition)
        return pieces

    def _when(self, clause: _Clause, values: Mapping[str, str]) -> str:
        # With one equation of an array for those of its elements.
        ((condition, body),) = clause.branches
        pieces, elements = list[_Piece](), dict[str, dict[str, str]]()
        for line, piece in self.equations(body, values, unrolls=True):
            match = _ELEMENT.fullmatch(piece)
            if match is None:
                pieces.append((line, piece))
                continue
            name, place, value = match.groups()
            if elements.setdefault(name, {}).setdefault(place.replace(" ", ""), value) is not value:
                raise RewritingError  # it has two equations
        line = clause.tokens[0].line
        pieces += [
            (line, f"{name} = {_constructor(self.sizes(name, all_.keys()), all_)}") for name, all_ in elements.items()
        ]
        inner = _on_lines(pieces, line, clause.tokens[-1].line)
        return f"when {self.text(condition, values)} then{inner} end when"

    def sizes(self, name: str, places: Set[str]) -> list[int]:
        """Return the sizes of an array.

        Raises:
            RewritingError: They are not known, or the places are not those of all elements.
        """
        variable = self.scope.variables.get(name)
        sizes = [self.size(size) for size in variable.sizes] if variable else [None]
        known = [size for size in sizes if size is not None]
        points = product(*(range(1, size + 1) for size in known))
        if known != sizes or places != {",".join(map(str, point)) for point in points}:
            raise RewritingError
        return known

    def assertion(self, tokens: Sequence[_Token], values: Mapping[str, str], wrap: Callable[[str], str]) -> str:
        condition, *others = _split(tokens[2 : _closing(tokens, 1)])
        if condition[1:2] and condition[1].text == "=":
            raise RewritingError
        return f"assert({', '.join([wrap(self.text(condition, values)), *(self.text(o, values) for o in others)])})"

    def points(self, statement: _Clause, values: Mapping[str, str]) -> Iterator[Mapping[str, str]]:
        """Yield the values of iterators in each repetition of a for."""
        iterators = statement.iterators
        if not iterators:
            yield values
            return
        (name, range_), *others = iterators
        for value in self._range(name, range_, statement, values):
            self.count += 1
            if self.count > _LONGEST:
                raise RewritingError
            yield from self.points(replace(statement, iterators=tuple(others)), {**values, name: value})

    def _range(
        self, name: str, range_: Sequence[_Token], statement: _Clause, values: Mapping[str, str]
    ) -> Sequence[str]:
        if not range_:
            found = _place_of(name, [t for _, body in statement.branches for s in body for t in s.tokens])
            variable = self.scope.variables.get(found[0].text) if found else None
            size = self.size(variable.sizes[found[1]]) if found and variable else None
            if size is None:
                raise RewritingError
            return [str(k) for k in range(1, size + 1)]
        if range_[0].text == "{":
            return [f"({self.text(part, values)})" for part in _listed(range_)]
        limits = [self.number(self.text(part, values)) for part in _split(range_, ":")]
        if len(limits) not in (2, 3) or None in limits:
            raise RewritingError
        first, *step, last = (limit for limit in limits if limit is not None)
        by = step[0] if step else 1
        count = floor((last - first) / by * (1 + 1e-12)) + 1 if by else 0
        return [f"({first + k * by!r})" for k in range(count)]

    def size(self, tokens: Sequence[_Token]) -> int | None:
        """Return a size of an array, None if it is not known."""
        value = self.number(self.text(tokens, {}))
        return int(value) if isinstance(value, int) and value >= 0 else None

    def number(self, text: str) -> float | None:
        """Return the value of an expression of numbers, constants and sizes, None for any other."""

        def known(match: re.Match[str]) -> str:
            variable = self.scope.variables.get(match[0])
            words = [token.text for token in variable.rest if token.text[0] != '"'] if variable else []
            if not variable or not variable.has_known_value or words[:1] != ["="]:
                return match[0]
            # Nothing else may give it another value; other classes may declare a variable of its name.
            before = re.findall(rf"(\S*)\s*\b{match[0]}\s*=(?!=)", self.every)
            is_redeclared = re.search(rf"\bredeclare\b[^;,()]*\sInteger\s+{match[0]}\b", self.every)
            is_own = len(before) == 1 or (set(before) == {"Integer"} and not is_redeclared)
            return f"({' '.join(words[1:])})" if is_own else match[0]

        def size_of(match: re.Match[str]) -> str:
            variable = self.scope.variables.get(match[1])
            sizes = variable.sizes[int(match[2]) - 1] if variable else ()
            size = None if any(token.text == "size" for token in sizes) else self.size(sizes)
            return match[0] if size is None else str(size)

        text = re.sub(r"\bsize\s*\(\s*(\w+)\s*,\s*(\d)\s*\)", size_of, text)
        return _number(re.sub(r"\b[^\W\d]\w*\b(?!\s*\()", known, text))

    def text(self, tokens: Sequence[_Token], values: Mapping[str, str]) -> str:
        """Return the text of an expression with iterators replaced."""
        own = {one.text for one, other in pairwise(tokens) if other.text == "in"}
        if own & (values.keys() | self.names):
            raise RewritingError
        out: list[str] = []
        k = 0
        while k < len(tokens):
            token = tokens[k]
            following = tokens[k + 1].text if k + 1 < len(tokens) else ""
            if token.text in _WORDS or not _NAME.fullmatch(token.text):
                if token.text.partition(".")[0] in self.names:
                    raise RewritingError
                out.append(token.text)
            elif following == "(":
                out.append(token.text)
                if token.text == "size":
                    out += ["(", tokens[k + 2].text]
                    k += 2
                elif token.text in ("pre", "der", "edge", "change"):
                    read = tokens[k + 2 : _closing(tokens, k + 1)]
                    if not self.names.isdisjoint(t.text.partition(".")[0] for t in read):
                        raise RewritingError
            elif following == "=" and out and out[-1] in ("(", ","):
                out.append(token.text)  # a named argument
            elif token.text in values:
                out.append(values[token.text])
            else:
                k = self.reference(tokens, k, values, out)
            k += 1
        text = " ".join(out)
        if len(text) > _LONGEST:
            raise RewritingError
        return text

    def reference(self, tokens: Sequence[_Token], k: int, values: Mapping[str, str], out: list[str]) -> int:
        """Append a reference to a variable, and return its last token."""
        out.append(tokens[k].text)
        if k + 1 == len(tokens) or tokens[k + 1].text != "[" or not values:
            return k
        end = _closing(tokens, k + 1)
        out.append(f"[{', '.join(self.subscript(part, values) for part in _split(tokens[k + 2 : end]))}]")
        return end

    def subscript(self, tokens: Sequence[_Token], values: Mapping[str, str]) -> str:
        """Return a subscript, as a number if it is known."""
        text = self.text(tokens, values)
        value = self.number(text)
        return str(value) if isinstance(value, int) else text


def _constructor(sizes: Sequence[int], elements: Mapping[str, str], before: tuple[int, ...] = ()) -> str:
    if not sizes:
        return elements[",".join(map(str, before))]
    parts = (_constructor(sizes[1:], elements, (*before, k)) for k in range(1, sizes[0] + 1))
    return f"{{{', '.join(parts)}}}"


def _is_assertion(statement: _Clause) -> bool:
    # Whether it is an assertion, or an if equation of nothing else.
    if statement.kind == "if":
        inner = [one for _, body in statement.branches for one in body]
        return bool(inner) and all(map(_is_assertion, inner))
    return not statement.kind and [token.text for token in statement.tokens[:2]] == ["assert", "("]


def _choice(cases: Iterable[tuple[str, str]]) -> str:
    # An if expression; the last case has no condition.
    words = [f"if {condition} then {value}" if condition else f" {value}" for condition, value in cases]
    return f"({' else'.join(words)})"


def _guarded(wrap: Callable[[str], str], skipped: Sequence[str], condition: str) -> Callable[[str], str]:
    # What must hold in a branch of an if, as an expression that is true elsewhere.
    before = [(other, "true") for other in skipped]
    after = [("", "true")] if condition else []
    return lambda holds: wrap(_choice([*before, (condition, holds), *after]))


class _Execution(_Unroller):
    """The equations of an algorithm section.

    Attributes:
        last: Variable or element → number of its last assignment outside of if statements, which the trial finds. From
            there on the variable has its final value, and other expressions refer to it instead of repeating it.
        written: Line and text of each equation.
        declared: Declarations of variables for the values of long expressions.
    """

    def __init__(self, scope: _Scope, every: str, last: dict[tuple[str, str], int], *, is_trial: bool) -> None:
        super().__init__(scope, every)
        self.last, self.is_trial = last, is_trial
        self.steps = 0
        self.written: list[_Piece] = []
        self.declared: list[str] = []
        self.final: set[tuple[str, str]] = set()
        self.names = frozenset(name for name, _ in last)
        self.now: dict[tuple[str, str], str] = {}

    def run(self, statements: Sequence[_Clause]) -> None:
        """Execute all statements.

        Raises:
            RewritingError: A statement is not supported, or an array is not assigned as a whole.
        """
        self._execute(statements, {}, None)
        for name in {name for name, _ in self.last}:
            places = {place for one, place in self.last if one == name}
            variable = self.scope.variables.get(name)
            if variable and variable.prefixes & {"parameter", "constant", "input"}:
                raise RewritingError
            if places != {""}:
                self.sizes(name, places)
        if not self.is_trial and self.final != self.last.keys():
            raise RewritingError

    def _execute(
        self, statements: Iterable[_Clause], values: Mapping[str, str], guard: Callable[[str], str] | None
    ) -> None:
        for statement in statements:
            if statement.kind == "for":
                for inside in self.points(statement, values):
                    self._execute(statement.branches[0][1], inside, guard)
            elif statement.kind == "if":
                self._choose(statement, values, guard)
            else:
                self._simple(statement.tokens, values, guard)

    def _simple(self, tokens: Sequence[_Token], values: Mapping[str, str], guard: Callable[[str], str] | None) -> None:
        words = [token.text for token in tokens]
        if {"annotation", "when", "while", "break", "return"} & set(words) or (words and words[-1][0] == '"'):
            raise RewritingError
        line = tokens[0].line
        if words[:2] == ["assert", "("] and _closing(tokens, 1) == len(tokens) - 1:
            self.written.append((line, self.assertion(tokens, values, guard or str)))
            return
        if ":=" not in words:
            raise RewritingError
        equals = words.index(":=")
        value = self.text(tokens[equals + 1 :], values)
        if words[0] == "(":
            targets = [self._target(part, values) for part in _split(tokens[1 : equals - 1])]
            if guard or None in (self._assign(target, None, line) for target in targets):
                raise RewritingError
            self.written.append((line, f"({', '.join(map(_written, targets))}) = {value}"))
            return
        target = self._target(tokens[:equals], values)
        if guard:
            self.now[target] = f"({value})"
        else:
            self._assign(target, value, line)

    def _target(self, tokens: Sequence[_Token], values: Mapping[str, str]) -> tuple[str, str]:
        if not tokens or not re.fullmatch(r"[^\W\d]\w*", tokens[0].text) or tokens[0].text in values:
            raise RewritingError
        subscripts, rest = _subscripts(tokens[1:])
        places = [self.subscript(part, values) for part in subscripts]
        if rest or not all(place.isdigit() for place in places):
            raise RewritingError
        return tokens[0].text, ",".join(places)

    def _assign(self, target: tuple[str, str], value: str | None, line: int) -> str | None:
        # The name of the variable if this is its final value; without a value that is required.
        self.steps += 1
        self.names |= {target[0]}
        if self.is_trial:
            self.last[target] = self.steps
        is_last = self.last[target] == self.steps
        name = _written(target)
        if not is_last or self.is_trial:
            self.now[target] = name if value is None else self._named(target, value, line)
            return name if is_last else None
        if value is not None:
            self.written.append((line, f"{name} = {value}"))
        self.now[target] = name
        self.final.add(target)
        return name

    def _named(self, target: tuple[str, str], value: str, line: int) -> str:
        # A long value, which other expressions may repeat many times, becomes a variable.
        variable = self.scope.variables.get(target[0])
        if len(value) < _LONG or variable is None or variable.type not in ("Real", "Integer", "Boolean"):
            return f"({value})"
        name = f"algorithm__{line}__{self.steps}"
        if bool(variable.sizes) != bool(target[1]) or name in self.every:
            raise RewritingError
        self.declared.append(f"protected {variable.type} {name}; ")
        self.written.append((line, f"{name} = {value}"))
        return name

    def _choose(self, statement: _Clause, values: Mapping[str, str], guard: Callable[[str], str] | None) -> None:
        before, outcomes = dict(self.now), list[tuple[str, dict[tuple[str, str], str]]]()
        skipped: list[str] = []
        for tokens, body in statement.branches:
            condition = self.text(tokens, values) if tokens else ""
            self._execute(body, values, _guarded(guard or str, skipped, condition))
            outcomes.append((condition, self.now))
            self.now = dict(before)
            skipped = [*skipped, condition]
        if outcomes[-1][0]:
            outcomes.append(("", before))
        changed = [target for _, now in outcomes for target in now if now[target] != before.get(target)]
        for target in dict.fromkeys(changed):
            value = _choice((c, now[target] if target in now else self._initial(target)) for c, now in outcomes)
            if guard:
                self.now[target] = value
            else:
                self._assign(target, value, statement.tokens[0].line)

    def _initial(self, target: tuple[str, str]) -> str:
        name = target[0]
        variable = self.scope.variables.get(name)
        start = rf"\b{name}\b\s*(?:\[[^\]]*\]\s*)?\([^;]*\bstart\b|\b{name}\s*\.\s*start\b"
        if not variable or variable.type != "Real" or "discrete" in variable.prefixes:
            raise RewritingError
        if bool(variable.sizes) != bool(target[1]) or re.search(start, self.every):
            raise RewritingError
        return "0.0"

    def reference(self, tokens: Sequence[_Token], k: int, values: Mapping[str, str], out: list[str]) -> int:
        name = tokens[k].text
        if name.partition(".")[0] not in self.names or self.is_trial:
            return super().reference(tokens, k, values, out)
        if "." in name:
            raise RewritingError
        elements = {target for target in self.last if target[0] == name}
        end, place = k, ""
        if k + 1 < len(tokens) and tokens[k + 1].text == "[":
            end = _closing(tokens, k + 1)
            place = ",".join(self.subscript(part, values) for part in _split(tokens[k + 2 : end]))
        target = (name, place)
        if elements <= self.final:
            out.append(_written(target))
        elif target in self.now:
            out.append(self.now[target])
        elif target in elements:
            out.append(self._initial(target))
        else:
            raise RewritingError
        return end


def _written(target: tuple[str, str]) -> str:
    return f"{target[0]}[{target[1]}]" if target[1] else target[0]


# Expressions and modifiers


def _in_brackets(tokens: Sequence[_Token]) -> Iterator[_Edit]:
    for begin, k in _bracketed(tokens):
        if tokens[k].text == "for":
            with contextlib.suppress(RewritingError):
                yield from _reduction(tokens, begin, k)
        elif "." in tokens[k].text[1:] and tokens[k + 1 : k + 2] and tokens[k + 1].text == "=":
            yield from _dotted_modifier(tokens, begin, k)


def _bracketed(tokens: Sequence[_Token]) -> Iterator[tuple[int, int]]:
    # The innermost bracket around each token, and the token.
    opened: list[int] = []
    for k, token in enumerate(tokens):
        if token.text in "([{":
            opened.append(k)
        elif token.text in ")]}" and opened:
            opened.pop()
        elif opened:
            yield opened[-1], k


def _reduction(tokens: Sequence[_Token], begin: int, k: int) -> Iterator[_Edit]:
    end = _closing(tokens, begin)
    iterators = _iterators(tokens[k + 1 : end])
    argument = tokens[begin + 1 : k]
    if len(iterators) == 1 and iterators[0][1] and iterators[0][1][0].text == "{":
        name, range_ = iterators[0]
        is_call = tokens[begin].text == "("
        is_known = not is_call or tokens[begin - 1].text in ("sum", "product", "min", "max")
        if is_known and "for" not in [t.text for t in argument]:
            unroller = _Unroller(_Scope(""), "")
            parts = [f"({unroller.text(part, {})})" for part in _listed(range_)]
            text = ", ".join(unroller.text(argument, {name: part}) for part in parts)
            lines = "\n" * (tokens[end].line - tokens[begin].line)
            yield tokens[begin].end, tokens[end].start, (f"{{{text}}}" if is_call else text) + lines
        return
    if tokens[begin].text == "{" and len(iterators) > 1:  # 10.4.1
        yield tokens[begin].start, tokens[begin].start, "{"
        place = k
        for part in _split(tokens[k + 1 : end])[:-1]:
            place += len(part) + 1  # the comma after this iterator
            yield tokens[place].start, tokens[place].end, "} for"
    for name, range_ in iterators:
        found = None if range_ else _place_of(name, argument)
        if found:
            place = next(t for t in tokens[k + 1 :] if t.text == name)
            yield place.end, place.end, f" in 1:size({found[0].text}, {found[1] + 1})"


def _dotted_modifier(tokens: Sequence[_Token], begin: int, k: int) -> Iterator[_Edit]:
    first, *rest = tokens[k].text.split(".")
    siblings = _split(tokens[begin + 1 : _closing(tokens, begin)])
    words = [[t.text.partition(".")[0] for t in part if t.text not in ("each", "final")][:1] for part in siblings]
    if tokens[begin].text != "(" or not first or words.count([first]) > 1 or tokens[k - 1].text not in "(,":
        return
    end = next(part[-1].end for part in siblings if tokens[k] in part)
    yield tokens[k].start, tokens[k].end, f"{first}({'('.join(rest)}"
    yield end, end, ")" * len(rest)


# Empty ranges


def _iterations(tokens: Sequence[_Token]) -> list[tuple[int, int]]:
    # The bracket and the `for` of each array constructor and reduction.
    return [(begin, k) for begin, k in _bracketed(tokens) if tokens[k].text == "for"]


def _with_first_elements(text: str) -> str:
    tokens, edits = _tokens(text), list[_Edit]()
    for begin, _ in _iterations(tokens):
        if tokens[begin].text == "(":  # a reduction becomes one of an array
            end = tokens[_closing(tokens, begin)].start
            edits += [(tokens[begin].end, tokens[begin].end, "{"), (end, end, "}")]
    text = _edited(text, edits)
    text = _edited(text, _in_brackets(_tokens(text)))
    tokens, edits = _tokens(text), list[_Edit]()
    sections = [(scope, first, end) for scope in _scopes(tokens) for _, first, end in scope.sections]
    for begin, k in _iterations(tokens):
        for scope, first, end in sections:
            if scope.kind != "function" and first <= k < end:
                with contextlib.suppress(RewritingError, IndexError):
                    edits += _first_element(scope, tokens, begin, k)
    return _edited(text, edits)


def _first_element(scope: _Scope, tokens: Sequence[_Token], begin: int, k: int) -> Iterator[_Edit]:
    # The front end evaluates a condition of numbers before subscripts, so that x[0] may follow it.
    end = _closing(tokens, begin)
    name, (first, *step, _), size = _range_of(scope, tokens[k + 1 : end])
    by = f"({step[0]})" if step else "1"
    before = f"({first}) - {by}"
    inner, sizes = tokens[begin + 1 : k], list[str]()
    while inner[0].text == "{" and (own := [j for b, j in _iterations(inner) if not b]):
        sizes.append(_range_of(scope, inner[own[0] + 1 : -1])[2])
        inner = inner[1 : own[0]]
    value = _value_of_its_type(scope, tokens, {token.text for token in inner})
    value = f"fill({', '.join([value, *sizes])})" if sizes else value
    yield tokens[begin].start, tokens[begin].end, f"({{if {name} == {before} then {value} else "
    lines = "\n" * (tokens[end].line - tokens[k + 1].line)
    new = f"{name} in {before}:{by}:({first}) + {by}*({size} - 1)}})[2:{size} + 1]"
    yield tokens[k + 1].start, tokens[end].end, new + lines


def _value_of_its_type(scope: _Scope, tokens: Sequence[_Token], words: Set[str]) -> str:
    # If the type of an expression with these words is Real or not known, a value of Real.
    iterators = {one.text for one, other in pairwise(tokens) if other.text == "in"}
    integers = iterators | {name for name, variable in scope.variables.items() if variable.type == "Integer"}
    if words & {"<", ">", "<=", ">=", "==", "<>", "and", "or", "not", "true", "false"} and "if" not in words:
        return "false"
    return "0" if all(re.fullmatch(r"\d+|[-+*()]", word) for word in words - integers) else "0.0"


def _range_of(scope: _Scope, tokens: Sequence[_Token]) -> tuple[str, list[str], str]:
    # The name of an iterator, the limits of its range, and the size of that. The front end does not evaluate the size
    # of an array there, but that in its declaration.
    iterators = _iterators(tokens)
    if len(iterators) != 1:
        raise RewritingError
    ((name, range_),) = iterators
    text = " ".join(token.text for token in range_)

    def declared(match: re.Match[str]) -> str:
        variable = scope.variables.get(match[1])
        size = " ".join(token.text for token in variable.sizes[int(match[2]) - 1]) if variable else ":"
        return match[0] if ":" in size else f"({size})"

    text = re.sub(r"\bsize \( (\w+) , (\d) \)", declared, text)
    limits = [" ".join(token.text for token in part) for part in _split(_tokens(text), ":")]
    if len(limits) not in (2, 3) or "for" in [token.text for token in range_]:
        raise RewritingError
    return name, limits, f"size({text}, 1)"
