"""Finished stops with a user's class are kept while all that the class consists of and reads is as it was."""

import pytest
from users_parts import SHORT
from wrong import table

import railgrip as rg
from railgrip.campaign.run import find_result, run
from railgrip.cli.runs import runner
from railgrip.scenario.campaign import PlannedStop

FILES = table(__file__, "tables.toml")["kept_law"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("own")
    (place / "first").mkdir()
    for name, text in FILES.items():
        (place / name).write_text(text)
    return place


@pytest.fixture(scope="module")
def stop(folder):
    """A stop with the class, which has a result in the folder `out`."""
    scenario = rg.Scenario.load("trapezoid", {**SHORT, "controller": {"kind": "kept_law:Hold"}})
    planned = PlannedStop(name="own", variants={}, scenario=scenario)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)  # `start` imports a module
        run(scenario, folder / "out", runner([folder]))
    return planned


@pytest.mark.parametrize(
    ("changed", "is_kept"),
    [
        (None, True),
        ("kept_law.py", False),
        ("kept_helper.py", False),
        ("kept_late.py", False),
        ("weight.txt", False),
        ("option.txt", False),
        ("first/kept_law.py", False),
        ("log.txt", True),
        ("data.csv", True),
        ("first/weight.txt", True),
    ],
)
def test_a_result_is_kept_while_class_imports_and_files_are_as_they_were(folder, stop, changed, is_kept):
    """Also a file that the class looked for, and a class of the same name in a folder that is searched earlier."""
    before = None
    if changed is not None:
        path = folder / changed
        before = path.read_bytes() if path.exists() else None
        path.write_bytes((before or b"") + b"\n# changed\n")
    try:
        found = find_result(stop, folder / "out", [folder / "first", folder])
    finally:
        if before is not None:
            path.write_bytes(before)
        elif changed is not None:
            path.unlink()
    assert (found is not None) is is_kept


def test_a_result_of_another_package_or_from_another_folder_is_not_kept(folder, stop, monkeypatch):
    result = find_result(stop, folder / "out", [folder])
    assert {"module kept_law", "package numpy"} <= result.dependencies.keys()
    assert find_result(stop, folder / "out", [folder / "first"]) is None
    monkeypatch.setattr("railgrip.simulate.user_files.metadata.version", lambda name: "0")
    assert find_result(stop, folder / "out", [folder]) is None
