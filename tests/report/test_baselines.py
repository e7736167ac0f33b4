"""Baselines keep distances, report changes, and are only changed with a reason."""

from dataclasses import replace

import numpy as np
import pytest
from command_line import done
from validation import with_distances

from railgrip.base.errors import ScenarioError
from railgrip.report.baseline import (
    AcceptedFigure,
    AcceptedValue,
    Baseline,
    Finding,
    Findings,
    accept,
    baseline_deviations,
    compare,
    comparison_table,
    findings_of,
    load_baseline,
    read_findings,
    write_baseline,
    write_findings,
)
from railgrip.report.results import by_compiler, read_results
from railgrip.scenario.conditioning import RepeatedDistances
from railgrip.scenario.outcome import Outcome

TWO = {"trapezoid-ideal-slip_two_state", "trapezoid-ideal-full_brake"}
SBC, FULL = "trapezoid-ideal-slip_two_state", "trapezoid-ideal-full_brake"


@pytest.fixture(scope="module")
def written(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("baseline") / "table1"
    write_campaign(directory, lambda stop: stop.name in TWO)
    return directory


@pytest.fixture(scope="module")
def results(written):
    return read_results(written)


def distance(results, name):
    return next(stop.metrics.distance for stop in results.stops if stop.name == name)


def metres(value, tolerance=0.5, **more):
    return AcceptedValue(unit="m", value=value, tolerance=tolerance, reason="First.", **more)


def baseline(**stops):
    names = {"sbc": SBC, "full": FULL}
    return Baseline(campaign="c.toml", accepted={names.get(name, name): stop for name, stop in stops.items()})


def read_back(accepted, folder):
    """Return a baseline as written to a file and read from it."""
    write_baseline(accepted, folder / "b.toml")
    return load_baseline(folder / "b.toml")


def states(comparisons):
    return {comparison.name: comparison.state for comparison in comparisons}


def test_accepting_changes_only_what_moved_and_keeps_the_relative_tolerance(results):
    moved_distance = distance(results, SBC)
    kept = metres(distance(results, FULL) + 0.1)
    before = baseline(sbc=metres(moved_distance / 2, moved_distance / 200), full=kept)
    after = accept(before, findings_of(results), "Heavier train.")
    assert after.accepted[FULL].model_copy(update={"adhesion_peak": None, "longest_lock": None}) == kept
    assert after.accepted[FULL].adhesion_peak is not None
    assert after.accepted[SBC].value == pytest.approx(moved_distance, abs=1e-3)
    assert after.accepted[SBC].tolerance == pytest.approx(moved_distance / 100, rel=0.05)  # written with two digits
    assert after.accepted[SBC].reason == "Heavier train."


def test_a_new_stop_gets_the_tolerance_of_arithmetic(results):
    after = accept(Baseline(campaign="c"), findings_of(results), "New.")
    assert after.accepted[SBC].tolerance == pytest.approx(1e-3 * distance(results, SBC), rel=0.05)


def test_a_stop_without_standstill_cannot_be_accepted(results):
    sliding = replace(results, stops=tuple(replace(s, outcome=Outcome.HORIZON) for s in results.stops))
    assert set(states(compare(Baseline(campaign="c"), findings_of(sliding))).values()) == {"no value"}
    with pytest.raises(ScenarioError, match="has no value"):
        accept(Baseline(campaign="c"), findings_of(sliding), "Why not.")


def test_a_stop_without_result_stays_in_the_baseline(results):
    before = baseline(x=metres(1))
    with pytest.raises(ScenarioError, match="x has no result; run the campaign first"):
        accept(before, findings_of(replace(results, missing=("x",))), "Gone.")
    assert "x" not in accept(before, findings_of(results), "No longer planned.").accepted


def study(**figures):
    return Findings(
        values=tuple(Finding(name=name, value=value, unit="1", tolerance=0.01) for name, value in figures.items())
    )


def figure(value, reason="First."):
    return AcceptedValue(value=value, tolerance=0.01, unit="1", reason=reason)


def test_figures_of_a_study_are_kept_moved_and_missed_like_distances():
    before = Baseline(study="s", accepted={"a": figure(0.5), "b": figure(0.5), "c": figure(0.0), "d": figure(1.0)})
    comparisons = compare(before, study(a=0.509, b=0.511, c=None, e=0.2))
    assert states(comparisons) == {"a": "kept", "b": "moved", "c": "no value", "d": "gone", "e": "new"}
    assert {row["unit"] for row in comparison_table(comparisons).rows} == {"1"}
    with pytest.raises(ScenarioError, match="accept: c has no value"):
        accept(before, study(a=0.509, c=None), "Why not.")
    after = accept(before, study(a=0.509, b=0.511, e=0.2), "A better filter.")
    assert after.accepted == {
        "a": figure(0.5), "b": figure(0.511, "A better filter."), "e": figure(0.2, "A better filter."),
    }  # fmt: skip


def test_figures_read_back_and_are_written_as_accepted(tmp_path):
    findings = study(a=0.0, b=-3.25e-5)
    write_findings(findings, tmp_path)
    assert read_findings(tmp_path) == findings
    after = accept(Baseline(study="s"), findings, "First: größer.")
    assert read_back(after, tmp_path) == after


def test_distances_agree_across_compilers_to_half_a_percent():
    """The law as printed stopped in 324.3 m with the built-in compiler and in 279.8 m with OpenModelica, 1e-7 apart."""
    differing = metres(324.3, 0.38, compilers={"openmodelica": (279.8, 279.8)})
    plain = metres(380.0, 0.38, compilers={"openmodelica": (381.0, 381.0)})
    wide = baseline(plain=plain, differing=differing).across_compilers()

    def found(**distances: float) -> dict[str, str]:
        return states(
            compare(wide, Findings(values=tuple(Finding(name=n, value=d, unit="m") for n, d in distances.items())))
        )

    for distance in (378.2, 380.0, 381.8):
        assert found(plain=distance, differing=300.0)["plain"] == "kept"
    for distance in (377.9, 382.1):
        assert found(plain=distance, differing=300.0)["plain"] == "moved"
    for distance in (279.8, 301.0, 324.3):
        assert found(plain=380.0, differing=distance)["differing"] == "kept"
    for distance in (277.9, 326.2):
        assert found(plain=380.0, differing=distance)["differing"] == "moved"


def test_the_value_of_another_compiler_is_kept_when_the_distance_moves(tmp_path):
    before = baseline(sbc=metres(324.3, 0.33, compilers={"openmodelica": (279.8, 280.1)}))
    after = accept(before, stop_with(), 'A "quoted" reason – with a dash.')
    assert after.accepted[SBC].compilers == {"openmodelica": (279.8, 280.1)}
    assert read_back(after, tmp_path) == after


def test_distances_of_the_built_in_compiler_are_not_those_of_another(written, capfd):
    result = done(capfd, "tools", "validation", "--openmodelica", written.parent)
    assert result.refuses("are those of the built-in compiler; run `make regress-omc`")


def test_distances_of_another_compiler_are_added_to_the_baseline(results):
    """A range is extended; a single distance is replaced."""
    found = {name: round(distance(results, name), 3) for name in (SBC, FULL)}
    known = {"openmodelica": (279.8, 280.1)}
    before = baseline(
        sbc=metres(281.0, 0.3, lowest=280.0, highest=282.0, compilers=known), full=metres(280.0, 0.3, compilers=known)
    )
    versions = {"TwoPartTrain.fmu": "OpenModelica Compiler v1.27.0"}
    elsewhere = replace(results, stops=tuple(replace(stop, versions=versions) for stop in results.stops))
    after = with_distances(before, elsewhere).accepted
    assert after[SBC].compilers["openmodelica"] == (min(279.8, found[SBC]), max(280.1, found[SBC]))
    assert after[FULL].compilers["openmodelica"] == (found[FULL], found[FULL])


def test_distances_of_another_compiler_beyond_half_a_percent_are_reported(results, tmp_path):
    """Nothing is reported if all FMUs are built-in: their distances have separate tolerances."""
    file, (moved, kept) = tmp_path / "table1.toml", (distance(results, name) for name in (SBC, FULL))
    write_baseline(baseline(sbc=metres(moved * 1.01, 0.1), full=metres(kept * 1.004, 0.1)), file)

    def made_by(tool):
        versions = {"TwoPartTrain.fmu": tool}
        made = tuple(replace(stop, versions=versions) for stop in results.stops)
        return replace(results, stops=made)

    (sentence,) = baseline_deviations(made_by("OpenModelica Compiler v1.27.0"), file)
    assert sentence.startswith(f"{SBC}: {distance(results, SBC):.2f} m by FMUs of another compiler")
    assert sentence.endswith("-1.0 %.")
    assert baseline_deviations(made_by("railgrip (rumoca 0.10)"), file) == []
    assert baseline_deviations(made_by("OpenModelica Compiler v1.27.0"), tmp_path / "none.toml") == []
    assert by_compiler(made_by("OpenModelica v1.27.0").stops) == ["FMUs by OpenModelica v1.27.0: TwoPartTrain.fmu."]


def repeats(distances=(300.0, 300.0, 300.01, 300.0), **figures):
    return RepeatedDistances(digest="d", distances=distances, figures=figures)


def stop_with(repeated=None, value=300.0, **figures):
    return Findings(values=(Finding(name=SBC, value=value, unit="m", repeated=repeated, figures=figures),))


def test_a_stop_moves_with_another_figure_than_distance_and_the_table_names_it():
    before = baseline(sbc=metres(300.0, 0.3, figures={"nis_ratio": AcceptedFigure(value=1.0, tolerance=1e-3)}))
    assert states(compare(before, stop_with(nis_ratio=1.0009))) == {SBC: "kept"}
    for figures in ({"nis_ratio": 1.0011}, {}):  # a figure that is missing is not kept either
        (moved,) = compare(before, stop_with(**figures))
        assert (moved.state, moved.change) == ("moved", 0.0)
        assert "nis_ratio 1 →" in comparison_table([moved]).rows[0]["figures"]
    assert states(compare(before.across_compilers(), stop_with(nis_ratio=2.0))) == {SBC: "kept"}


def test_a_stop_without_a_reproducible_figure_is_compared_by_less_reproducible_ones():
    """Student's t of four degrees of freedom at 99.99 % is 15.54: 2.4 % for the air, and too much for the strokes."""
    some = {"air_used": (1.0, 1.002, 0.998, 1.0, 1.0), "actuations": (100.0, 101.0, 99.0, 100.0, 100.0)}
    after = accept(Baseline(campaign="c"), stop_with(repeats(**some), air_used=1.0, actuations=100.0), "r")
    figures = after.accepted[SBC].figures
    assert set(figures) == {"air_used"}
    assert figures["air_used"].tolerance == pytest.approx(
        15.54 * np.std(some["air_used"], ddof=1) * np.sqrt(1.2), rel=0.05
    )


def test_repeats_determine_the_accepted_figures_and_their_tolerances(tmp_path):
    repeated = repeats(nis_ratio=(1.0, 1.0005, 0.9995, 1.0), air_used=(1.0, 1.1, 0.9, 1.0), longest_lock=(0.0,) * 4)
    found = stop_with(repeated, nis_ratio=1.0, air_used=1.0, longest_lock=0.0, adhesion_rmse=0.1)
    after = accept(Baseline(campaign="c"), found, "New figures.")
    figures = after.accepted[SBC].figures
    # Air varies by more than 0.5 %, and the error has no repeats.
    assert set(figures) == {"nis_ratio", "longest_lock"}
    # 99 % of Student's t with three degrees of freedom is 5.841.
    spread = np.std((1.0, 1.0005, 0.9995, 1.0), ddof=1)
    assert figures["nis_ratio"].tolerance == pytest.approx(5.841 * spread * np.sqrt(1.25), rel=0.05)
    assert states(compare(after, stop_with(nis_ratio=1.0, longest_lock=0.01))) == {SBC: "moved"}
    assert read_back(after, tmp_path) == after


def test_a_smooth_distance_is_kept_to_two_centimetres_and_does_not_move():
    before = baseline(sbc=metres(300.005, 0.3))
    smooth, rough = accept(before, stop_with(repeats()), "Smooth."), repeats((300.0, 300.03))
    assert smooth.accepted[SBC] == before.accepted[SBC].model_copy(update={"tolerance": 0.02})
    assert accept(before, stop_with(rough), "Rough.").accepted == before.accepted
