"""Places of errors in Modelica code, for which the front end often names only the element, without file and line."""

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import islice
from pathlib import Path

import rumoca

from railgrip.base.errors import InputError
from railgrip.base.files import read_bytes
from railgrip.base.tables import TomlTable
from railgrip.fmus.native.classes import KINDS, blank, without_texts
from railgrip.fmus.native.library import BYTE_ORDER_MARK, library_of, modelica_files, read_utf_8

_MAXIMUM_PLACES = 3
"""Maximum number of places in a message."""


@cache
def _messages(kind: str) -> list[TomlTable]:
    # A table of messages.toml, which describes its keys.
    return tomllib.loads(Path(__file__).with_name("messages.toml").read_text(encoding="utf-8"))[kind]


def places(message: str, path: Path, class_name: str) -> tuple[str, ...]:
    """Return `file.mo:line: text of the line` for an error of the front end, as far as it can be found.

    Args:
        message: Message of the front end.
        path: The file that was read; `package.mo` represents all files of its library.
        class_name: Name of the class to translate.
    """
    texts = _texts(path)
    syntax = [place for name, text in texts.items() for place in _syntax_errors(name, text)]
    if syntax:
        return tuple(syntax[:_MAXIMUM_PLACES])
    name = class_name.rpartition(".")[2]
    if not any(re.search(rf"\b(?:{KINDS})\s+{name}\b", text) for text in texts.values()):
        return (f"no file of it declares {name}",)
    named = [n for n in re.findall(r"['`]([\w.\[\]]+)['`]", message) if n != class_name]
    lines = tuple(_lines_with(re.findall(r"unresolved[^']*'([^']+)'", message), texts))
    if not lines and not re.search(r"\.mo:\d+", message):
        body = dict(_body(name, texts))
        last_parts = [re.sub(r"\[.*", "", n).rpartition(".")[2] for n in named]
        for names, where in ((named, body), (last_parts, body), (named, texts), (last_parts, texts), ([name], body)):
            lines = lines or tuple(_lines_with(names, where))
    return (*_undeclared_use(path, texts), *_class_within(path, texts, class_name), *lines[:_MAXIMUM_PLACES])


def _class_within(path: Path, texts: dict[str, str], class_name: str) -> Iterator[str]:
    found = re.match(r"\s*within\s+([\w.]+)\s*;", without_texts(texts[short(path, path)]))
    if path.name != "package.mo" and found and not class_name.startswith(f"{found[1]}."):
        yield f"{short(path, path)}:1: the file has `within {found[1]};`, so its class is {found[1]}.{class_name}"


def _body(name: str, texts: dict[str, str]) -> Iterator[tuple[str, str]]:
    # The definition of a class, below empty lines, so that its lines have their numbers.
    for file, text in texts.items():
        found = re.search(rf"\b(?:{KINDS})\s+{name}\b.*?\bend\s+{name}\b", text, re.DOTALL)
        if found:
            yield file, "\n" * text.count("\n", 0, found.start()) + found[0]
            return


def explain(message: str) -> str:
    """Return a message of the front end without repetitions, after a sentence on its meaning if it is internal."""
    message, _, related = message.partition("\nRelated failures")
    others = [line for line in related.splitlines()[1:] if line.rpartition("]: ")[2] not in message]
    message = "\n".join([message, *others[:_MAXIMUM_PLACES]])
    for row in _messages("explanations"):
        match = re.search(row["pattern"], message)
        if match:
            return f"{match.expand(row['sentence'])}. The front end reports: {message}"
    return message


def has_class_extends(path: Path) -> bool:
    """Return whether `model extends` or the like is in a file or library."""
    form = re.compile(rf"\b(?:{KINDS})\s+extends\b")
    return any(form.search(text) and form.search(without_texts(text)) for text in _texts(path).values())


def _within(file: Path, path: Path, text: str) -> str | None:
    # What is wrong with the clause `within` of a file of a library, or with the name of its class (13.4).
    code = without_texts(text)
    found = re.match(r"\s*(?:within\b\s*([\w.\s]*);)?", code)
    clause = "".join((found[1] or "").split()) if found else ""
    folder = file.parent.parent if file.name == "package.mo" else file.parent
    base = path.parent.parent
    # The folder of a library may have its version in its name.
    names = [part.partition(" ")[0] for part in folder.relative_to(base).parts] if path.name == "package.mo" else []
    required = ".".join(names)
    line = code.count("\n", 0, found.start(1)) + 1 if found and found[1] else 1
    if path.name == "package.mo" and clause != required:
        what = f"`within {clause};`" if clause else "no `within`"
        return f"{line}: the file has {what}, but its folder requires `within {required};` (13.4)"
    if path.name == "package.mo":
        name = file.parent.name.partition(" ")[0] if file.name == "package.mo" else file.stem
        declared = re.search(rf"\b(?:{KINDS})\s+(?:(?:extends|record|function)\s+)?(\w+)", code)
        if declared and declared[1] != name:
            line = code.count("\n", 0, declared.start()) + 1
            return f"{line}: the file declares {declared[1]}, but its name requires {name} (13.4)"
    return None


def _texts(path: Path) -> dict[str, str]:
    return {short(file, path): read_bytes(file).decode(errors="replace") for file in _files(path)}


def _files(path: Path) -> list[Path]:
    return [file for file in modelica_files(library_of(path)) if file.suffix == ".mo"]


_REFERENCE = re.compile(r"\b[A-Za-z_]\w*(?:\[[^\]\n]*\])?(?:\.\w+(?:\[[^\]\n]*\])?)*\.\w+\b(?!\s*[\[(])")
"""A reference to a variable of a component."""
_ADVICE = (
    "is not supported in a for equation or as a slice, because it goes through two arrays of components; write an "
    "array comprehension outside of for equations, as in y = {wheels[i].contact[1].slip for i in 1:4}, or numbers as "
    "indices, or declare a variable in the class of the outer component that equals the inner one, and refer to that."
)


def nested_arrays(message: str, path: Path, class_name: str) -> tuple[str, ...]:
    """Return a sentence for each reference through two arrays of components on which rumoca 0.10 fails.

    rumoca translates `wheels[i].contact[1].slip` with numbers as indices and in array comprehensions, but fails on it
    in for equations and slices; its message mentions semantic owners and has neither file nor line.

    Args:
        message: Message of the front end.
        path: See `places`.
        class_name: Name of the class to translate.
    """
    if "typed semantic owner" not in message and "member slice" not in message:
        return ()
    every, not_in_comprehension = list[str](), list[str]()
    for name, text in _texts(path).items():
        for match in _REFERENCE.finditer(text):
            subscripts = re.findall(r"\[([^\]]*)\]\.", f"{match[0]}.")
            is_indexed = len(subscripts) > 1 and not all(subscript.strip().isdigit() for subscript in subscripts)
            is_slice = "member slice" in message and match[0].count(".") > 1 and len(subscripts) == 1
            if is_indexed or is_slice:
                line = text.count("\n", 0, match.start()) + 1
                every.append(f"{name}:{line}: {class_name}: {match[0]} {_ADVICE}")
                # The `for` of a comprehension follows its expression; that of an equation precedes it.
                if not re.search(r"\bfor\s+\w+\s+in\b", text[match.end() :].partition(";")[0]):
                    not_in_comprehension.append(every[-1])
    # A comprehension fails only inside a for equation, so it is reported only if nothing else can be the cause.
    return tuple((not_in_comprehension or every)[:_MAXIMUM_PLACES])


def limits(message: str, path: Path, class_name: str, load: Callable[[str, Path], object]) -> tuple[str, ...]:
    """Return sentences with file and line for failures of the front end on valid or invalid forms that it cannot name.

    Args:
        message: Message of the front end.
        path: See `places`.
        class_name: Name of the class to translate.
        load: Function of another text of a file that translates the class with it.
    """
    if re.search(r":\d+:\d+\]", message):
        return ()
    for limit in _messages("limits"):
        match = re.search(limit["message"], message)
        if match is None:
            continue
        groups = match.groupdict()
        operator = groups.get("operator") or groups.get("operator2") or ""
        sentence = limit["sentence"].format(operator=operator)
        texts = _texts(path)
        if not limit.get("in_functions", True):
            texts = {name: _FUNCTION.sub(blank, text) for name, text in texts.items()}
        found = list(
            _statements(limit.get("source", "").replace("{operator}", operator), groups.get("function"), texts)
        )
        if not found:
            found = list(dict.fromkeys(_culprits(path, class_name, message, load)))
        if not found:
            declaration = rf"\b(?:model|block|class)\s+{class_name.rpartition('.')[2]}\b"
            found = list(_statements(declaration, None, texts))[:1]
            sentence += "; the place is in this class or one that it uses"
        return tuple(f"{place}: {class_name}: {sentence}: {line}" for place, line in found[:_MAXIMUM_PLACES])
    return ()


_FUNCTION = re.compile(r"\bfunction\s+(\w+)\b.*?\bend\s+\1\s*;", re.DOTALL)


def _statements(source: str, function: str | None, texts: dict[str, str]) -> Iterator[tuple[str, str]]:
    if not source:
        return
    for name, text in texts.items():
        begin, end = 0, len(text)
        if function:
            short_name = function.rpartition(".")[2]
            declared = re.search(rf"\bfunction\s+{short_name}\b.*?\bend\s+{short_name}\s*;", text, re.DOTALL)
            if declared is None:
                continue
            begin, end = declared.span()
        for match in re.compile(source, re.MULTILINE).finditer(without_texts(text), begin, end):
            yield _line_at(name, text, match.start())


def _line_at(name: str, text: str, position: int) -> tuple[str, str]:
    number = text.count("\n", 0, position) + 1
    line = text.splitlines()[number - 1].strip()
    return f"{name}:{number}", line if len(line) <= _LONGEST else f"{line[:_LONGEST]} …"


_LONGEST = 100
"""Maximum number of characters of a line in a message."""

_MOST_TRIALS = 300
"""Maximum number of statements that are left out in turn; each trial takes milliseconds in a small library."""
_MOST_CHARACTERS = 20_000_000
"""Maximum number of characters that all trials read, which takes some ten seconds."""
_BEFORE_STATEMENT = re.compile(
    r"\s*(?:(?:(?:initial\s+)?(?:equation|algorithm)|public|protected|else|(?:when|elsewhen|if|elseif)\b\s*(.*?)\bthen"
    r"|for\b.*?\bloop|(?:model|block|class|package|function)\s+\w+)\b\s*)?",
    re.DOTALL,
)
"""What may precede a statement up to the last semicolon; its group is a condition."""


def _ends(plain: str) -> Iterator[int]:
    # Places of the semicolons that end statements, not rows of matrices.
    depth = 0
    for k, c in enumerate(plain):
        depth += (c == "[") - (c == "]")
        if c == ";" and not depth:
            yield k


def _replacements(plain: str) -> Iterator[tuple[int, int, str]]:
    """Yield begin and end of conditions and right sides of a text, each with what has the same type and sizes."""
    start = 0
    for end in _ends(plain):
        before = _BEFORE_STATEMENT.match(plain, start, end)
        while before and before.end() > start:
            start = before.end()
            if before[1]:
                yield *before.span(1), " time > 1 "
            before = _BEFORE_STATEMENT.match(plain, start, end)
        equals = re.compile(r"(?<![<>=]):?=(?!=)\s*").search(plain, start, end)
        if equals:  # the left side, or the declared name on it
            left = plain[start : equals.start()]
            for side in (left, *re.findall(r"\b(\w+)\s*(?:\[[^\]]*\]\s*)?(?:\(.*\)\s*)?$", left, re.DOTALL)):
                yield equals.end(), end, f" {side} "
        start = end + 1


def _culprits(
    path: Path, class_name: str, message: str, load: Callable[[str, Path], object]
) -> Iterator[tuple[str, str]]:
    """Yield the statements without which the front end does not fail in this way, in the file of the class first."""
    stage, cause = message.partition(": ")[0], message.rpartition(": ")[2]

    def is_needed(file: Path, without: str) -> bool:
        try:
            load(without, file)
        except (rumoca.RumocaError, RuntimeError) as error:
            # An error of an earlier stage, or too few equations, shows that the rest of the text needs the statement.
            outcome = str(error)
            if "could not be compiled" in stage:
                return False
            return outcome.startswith(stage) and "unbalanced model" not in outcome and not outcome.endswith(cause)
        return True

    texts = {file: read_bytes(file).decode(errors="replace") for file in _files(path)}
    own = re.compile(rf"\b(?:{KINDS})\s+{class_name.rpartition('.')[2]}\b")
    trials = (
        (file, text, *trial)
        for file, text in sorted(texts.items(), key=lambda item: not own.search(item[1]))
        for trial in _replacements(without_texts(text))
    )
    size = sum(map(len, texts.values()))
    for file, text, begin, end, instead in islice(trials, min(_MOST_TRIALS, _MOST_CHARACTERS // max(size, 1))):
        if is_needed(file, text[:begin] + instead + text[end:]):
            yield _line_at(short(file, path), text, begin)


def _undeclared_use(path: Path, texts: dict[str, str]) -> Iterator[str]:
    class_text = texts[short(path, path)]
    foreign = path.name == "package.mo" and path.parent.name != "RailBraking"
    if foreign and "RailBraking" not in class_text and any("RailBraking." in text for text in texts.values()):
        yield f"{short(path, path)}: to use RailBraking it must have annotation(uses(RailBraking))"


def _syntax_errors(name: str, text: str) -> Iterator[str]:
    for problem in rumoca.validate_source(text):
        if problem.rule == "syntax-error":
            what = re.search(r"× (.+)", problem.message)
            where = re.search(r"\[[^\]]*:(\d+):\d+\]", problem.message)
            yield f"{name}:{where[1] if where else problem.line}: {what[1] if what else 'syntax error'}"
            return


def _lines_with(names: Iterable[str], texts: dict[str, str]) -> Iterator[str]:
    for name in dict.fromkeys(names):
        pattern = re.compile(rf"(?<![\w.]){re.escape(name)}(?!\w)")
        for file, text in texts.items():
            for number, line in enumerate(text.splitlines(), start=1):
                if pattern.search(line):
                    yield f"{file}:{number}: {line.strip()}"


_DEEPEST = 200
"""Maximum depth of nested brackets; rumoca's parser overflows its stack at a few thousand."""


def require_readable(path: Path) -> None:
    """Raise an error for Modelica on which the front end would crash.

    Args:
        path: The file to read; `package.mo` represents all files of its library.

    Raises:
        InputError: A file is not in UTF-8, begins with a byte order mark, has a `within` or a class that does not fit
            its place in the library, or has brackets nested too deeply.
    """
    for file in _files(path):
        text = read_utf_8(file)
        if text.startswith(BYTE_ORDER_MARK) and path.name == "package.mo":
            raise InputError(f"{file}:1: the file starts with a byte order mark; save it as UTF-8 without one.")
        misplaced = _within(file, path, text)
        if misplaced:
            raise InputError(f"{file}:{misplaced}.")
        depth = 0
        for token in re.finditer(r"[()\[\]{}]", without_texts(text)):
            depth += 1 if token[0] in "([{" else -1
            if depth > _DEEPEST:
                line = text.count("\n", 0, token.start()) + 1
                raise InputError(f"{file}:{line}: more than {_DEEPEST} nested brackets; declare parts as variables.")


def short(file: Path, path: Path, further: Path | None = None) -> str:
    """Return a file's path relative to the folder of the library of `path`, so that it is the same on every machine.

    The path of a file in the folder `further` is relative to that, and any other path is returned unchanged.
    """
    if further is not None and file.is_relative_to(further):
        return file.relative_to(further).as_posix()
    base = path.parents[2] if path.name == "package.mo" and len(path.parents) > 2 else path.parent
    return file.relative_to(base).as_posix() if file.is_relative_to(base) else file.as_posix()
