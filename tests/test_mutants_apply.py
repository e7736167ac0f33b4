"""Each mutant of `make mutants` still finds the text that it changes; `make mutants` itself runs the mutants."""

import mutants
import pytest

ALL = tuple(mutants.rows(mutants.DATA))


def test_there_are_eighty_mutants():
    assert len({mutant.meaning for mutant in ALL}) >= 80


@pytest.mark.parametrize("mutant", ALL, ids=lambda mutant: mutant.meaning)
def test_the_text_of_each_mutant_is_found(mutant, tmp_path):
    sources = tmp_path / "sources"
    for edit in mutant.edits:
        copy = sources / edit.file
        copy.parent.mkdir(parents=True, exist_ok=True)
        if not copy.exists():
            copy.write_bytes((mutants.ROOT / edit.file).read_bytes())
        edit.apply(sources)


def test_the_independent_checks_run(tmp_path):
    checks = mutants.DATA["checks"].values()
    files = {check.split()[0] for check in checks}
    mutants.copied(tmp_path)
    done = mutants.run_copied_tests(tmp_path, ["--collect-only", *sorted(files)])
    assert done.returncode == 0, f"the checks of `make mutants` cannot be collected: {done.stdout[-2000:]}"
    for check in checks:
        word = check.partition("-k ")[2]
        assert word in done.stdout, f"{check}: no test of this name"
