"""An input file may be a pipe, a device, a folder, huge, or not text: the command reports it at once in a sentence."""

import re

import pytest
from test_files_of_users import make_obstacle, needs_posix

COMMANDS = [
    "run wet.toml --set controller.kind=fmu --set controller.file=odd.fmu",
    "map odd.fmu",
    "build My.Train --library odd.mo",
    "ride odd.toml",
    "report odd.toml",
    "compare odd.toml odd.toml",
    "monitor odd.toml",
]
"""Commands whose files tests/test_files_of_users.py does not read."""


@needs_posix
@pytest.mark.usefixtures("alarm")
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "large", "not text"])
@pytest.mark.parametrize("words", COMMANDS)
def test_an_odd_file_is_refused_in_a_sentence(command, project, monkeypatch, words, kind):
    monkeypatch.chdir(project)
    make_obstacle(kind, project / re.search(r"odd\.\w+", words)[0])
    result = command(*words.split())
    assert result.code == 2, result.err
    assert len(result.err.strip()) > 20
