"""Studies: one command for all, results of cases cached by content, and sentences for missing studies."""

import itertools
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from one_process import one_process
from wrong import table

from railgrip import studies
from railgrip.base.errors import EstimationError, InputError
from railgrip.campaign.run import input_versions, sources_digest, studies_used
from railgrip.campaign.work import work
from railgrip.scenario.load import load
from railgrip.studies import bench, names
from railgrip.studies.bench import answer
from railgrip.studies.study import Study, study_named

COUNT = itertools.count(1)


@dataclass(frozen=True)
class Case:
    """A number and a path."""

    number: float
    place: Path = Path()


def counted(case):
    """Return the number of calls so far; a negative number is not a valid case."""
    if isinstance(case, Case) and case.number < 0:
        raise EstimationError("nobody knows.")
    return next(COUNT)


@pytest.fixture
def study_work(own_cache):
    with one_process(), work("etcs") as own:
        yield own


def test_the_bench_prints_the_time_of_a_stop_and_which_targets_are_exceeded():
    rows = [
        ("cold build of 9 FMUs", "9.8 s (16.1 s of processor)", "10 s"),
        (f"{bench.ABC}{bench.CYCLE}", "8.1 µs", ""),
        (bench.FASTER, "98", ""),
        ("  with assembly, without a trace", "11.0 µs", "10 µs"),
        (f"slip-based control{bench.CYCLE}", "3.0 µs", ""),
        (bench.FASTER, "200", ""),
        ("train of 4 four-axle cars", "0.03 ms", "25 µs for four cars"),
        ("stops that two processes end, over one", "1.95", "at least 1.9"),
        ("tuning", "40 ms", ""),
        ("  both objectives", "29.0 min", "30 min"),
    ]
    time, targets = answer(rows).split(". Of 5 durations and ratios with a target, 2 over target: ")
    assert time.startswith(f"With {bench.ABC} and a compiled law, a cycle of the loop takes 8.1 µs, and a stop ")
    assert time.endswith(" 98 times faster than real time")
    assert targets.startswith(f"{bench.ABC}: a cycle, law compiled – with assembly, without a trace: 11.0 µs, target")
    assert targets.endswith(" 10 µs; train of 4 four-axle cars: 0.03 ms, target 25 µs for four cars.")
    assert "none is over it." in answer([row for row in rows if row[1] not in ("11.0 µs", "0.03 ms")])
    assert "1.80, target at least 1.9." in answer([*rows, ("two processes", "1.80", "at least 1.9")])


def test_a_case_runs_once_whatever_its_values(study_work):
    scenario = load(Path("trapezoid"))
    cases = [
        Case(1.0), Case(2.0), Case(1.0, Path("here")), scenario, scenario.model_copy(update={"seed": 2}), "1.0",
        scenario.limits,
        {"a": np.zeros(3)}, {"a": np.zeros((3, 1))}, {"a": np.ones(3)}, (1, None),
    ]  # fmt: skip
    first = study_work.map(counted, [*cases, *cases])
    assert len(set(first)) == len(cases)
    assert first[: len(cases)] == first[len(cases) :]
    assert study_work.run_count == len(cases)
    assert study_work.map(counted, reversed(cases)) == first[len(cases) - 1 :: -1]
    assert study_work.run_count == len(cases)
    assert study_work.map(counted, [Case(1.0)], keep=False) != first[:1]


def test_fresh_cases_run_again_and_studies_do_not_share_results(study_work):
    results = study_work.map(counted, [Case(1.0)])
    with work("etcs", fresh=True) as fresh, work("benefit") as other:
        assert results != fresh.map(counted, [Case(1.0)]) != other.map(counted, [Case(1.0)]) != results


def test_a_case_that_fails_ends_the_study_and_is_not_cached(study_work):
    for _ in range(2):
        with pytest.raises(EstimationError, match="nobody knows"):
            study_work.map(counted, [Case(-1.0)])
    assert study_work.run_count == 0


@pytest.mark.parametrize("name", names())
def test_every_study_has_a_quick_form_that_never_writes_into_the_documentation(name):
    study = study_named(name)
    assert len(study.quick_form) > 5
    quick = study(quick=True).reduce()
    assert {key: getattr(quick, key) for key in study.quick_sizes} == dict(study.quick_sizes)
    if "write" in study.__dataclass_fields__:
        with pytest.raises(InputError, match=r"--write: only for the whole study; leave out --quick\."):
            study(quick=True, write=True).reduce()


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("benefit", {"draws": 40, "write": True}, "--write, --draws: "),
        ("type_test", {"cases": 24, "case": ["a"]}, "--case, --cases: "),
    ],
)
def test_a_quick_form_refuses_options_of_the_whole_study(command, name, options, words):
    with pytest.raises(InputError, match=words):
        study_named(name)(quick=True, **options).reduce()


def test_a_study_without_a_quick_form_cannot_be_defined():
    with pytest.raises(TypeError, match="quick"):
        type("Slow", (Study,), {})


def test_the_page_of_a_quick_form_begins_with_what_it_leaves_out(tmp_path, command):
    done = command("study", "etcs", "--quick", "--out", tmp_path)
    assert done.code == 0
    about = "This is the quick form of the study, which checks that it runs: the whole study."
    assert done.out.startswith(about)
    page = (tmp_path / "quick" / "index.html").read_text(encoding="utf-8")
    assert f'<p class="answer">{about}' in page
    assert "(quick form)</h1>" in page


def test_a_result_of_another_package_version_is_not_reused(study_work, monkeypatch):
    first = study_work.map(counted, [Case(7.0)])
    assert study_work.map(counted, [Case(7.0)]) == first
    monkeypatch.setattr("railgrip.campaign.work.input_versions", lambda study: input_versions(study) | {"numpy": "0"})
    assert study_work.map(counted, [Case(7.0)]) != first


def imported_by_each_study():
    """Return study → other studies that Python has imported with it, in a new interpreter."""
    program = """
import sys
from importlib import import_module
from railgrip.studies import module_of, names
for name in names():
    for module in [m for m in sys.modules if m.startswith("railgrip.studies.")]:
        del sys.modules[module]
    import_module(module_of(name))
    print(name, *sorted({m.split(".")[2] for m in sys.modules if m.startswith("railgrip.studies.")} - {"study"}))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return {line.split()[0]: set(line.split()[1:]) for line in done.stdout.splitlines()}


def test_a_digest_has_all_studies_whose_code_a_study_runs():
    """What Python imports; `studies_used` also has what is imported inside of functions."""
    folder = Path(studies.__file__).parent
    found = imported_by_each_study()
    assert found.keys() == set(names())
    for study, imported in found.items():
        assert imported <= studies_used(study, folder), study
    assert "type_test" in found["stop_at_target"]


SOURCES = table(__file__, "tables.toml")["sources"]


@pytest.mark.parametrize(("changed", "moves"), SOURCES)
@pytest.mark.parametrize("study", ["fleet", Path("pages/mine.py")])
def test_a_digest_changes_with_every_file_of_the_studies_that_are_used(tmp_path, monkeypatch, study, changed, moves):
    texts = {
        "studies/fleet.py": "from railgrip.studies.pads.life import live\nfrom railgrip.studies.study import Study\n",
        "studies/pads/life.py": "def live():\n    import railgrip.studies.rig as rig\n",
        "studies/rig.py": "from railgrip.studies import fleet\n",
        "../pages/mine.py": "import near\n",
        "../pages/near.py": "from railgrip.studies.fleet import Fleet\n",
    }
    for name, _ in SOURCES:
        path = tmp_path / "railgrip" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(texts.get(name, ""))
    monkeypatch.setattr("railgrip.campaign.run._PACKAGES", ("railgrip",))
    monkeypatch.setattr("railgrip.campaign.run.MODELICA", tmp_path / "modelica")
    monkeypatch.setattr(
        "railgrip.campaign.run.import_module", lambda name: SimpleNamespace(__path__=[str(tmp_path / name)])
    )
    monkeypatch.chdir(tmp_path)
    before = sources_digest.__wrapped__(study)
    (tmp_path / "railgrip" / changed).open("a").write("\n")
    assert (sources_digest.__wrapped__(study) != before) == (moves and not (study == "fleet" and "pages" in changed))
