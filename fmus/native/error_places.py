"""Places of errors in Modelica code, for which the front end often names only the element, without file and line."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import rumoca

from railgrip.base.errors import InputError
from railgrip.base.files import read_bytes

_MAXIMUM_PLACES = 3
"""Maximum number of places in a message."""


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
    if not any(re.search(rf"\b(?:model|block|class)\s+{name}\b", text) for text in texts.values()):
        return (f"no file of it declares {name}",)
    names = re.findall(r"unresolved[^']*'([^']+)'", message)
    return (*_undeclared_use(path, texts), *tuple(_lines_with(names, texts))[:_MAXIMUM_PLACES])


def _texts(path: Path) -> dict[str, str]:
    return {short(file, path): read_bytes(file).decode(errors="replace") for file in _files(path)}


def _files(path: Path) -> list[Path]:
    return sorted(path.parent.rglob("*.mo")) if path.name == "package.mo" else [path]


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
_TOKENS = re.compile(r"""//[^\n]*|/\*.*?\*/|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[(\[{]|[)\]}]""", re.DOTALL)


def require_readable(path: Path) -> None:
    """Raise an error for Modelica on which the front end would crash.

    Args:
        path: The file to read; `package.mo` represents all files of its library.

    Raises:
        InputError: A file is not in UTF-8, or has brackets nested too deeply.
    """
    for file in _files(path):
        content = read_bytes(file)
        try:
            text = content.decode()
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise InputError(f"{file}:{line}: the text is not UTF-8; save the file as UTF-8.") from error
        depth = 0
        for token in _TOKENS.finditer(text):
            depth += 1 if token[0] in "([{" else -1 if token[0] in ")]}" else 0
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
