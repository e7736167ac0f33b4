"""Tables of braking distances in docs/ and the figure above them, from the accepted distances so that both agree."""

import itertools
import math
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
import pandas
from matplotlib.figure import Figure

from railgrip.base.errors import ScenarioError
from railgrip.report.baseline import ACROSS_COMPILERS, AcceptedValue, Baseline, findings_of
from railgrip.report.campaign_figures import overview_figure
from railgrip.report.frame import Frame, StatedDistance
from railgrip.report.reference import label, locked_text, references
from railgrip.report.results import Results, from_elsewhere
from railgrip.report.statistics import median_interval, on_common, rank
from railgrip.report.table import ReportTable, names, percent, text, with_interval
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.conditioning import SMOOTH, RepeatedDistances, read_conditioning
from railgrip.scenario.onboard import SampledSensors

_FIRST = "braking distance"

_EQUIPMENT = {"ideal": "ideal, 20 ms lag", "instant": "ideal, 1 ms lag"}
"""Equipment → its name in the table, with the lag of the cylinder pressure; others have the name of the file."""


def stops_of(campaign: Campaign, accepted: Mapping[str, AcceptedValue]) -> Frame:
    """Return a row for each stop of a campaign with scenarios, equipment and controllers, with its accepted distance.

    Columns:

    - `stop`, `place`, `equipment`, `variant`, `controller`, `controller_label`: names of stop, scenario, equipment,
      variant of the controller, its kind, and its name for readers; `law`: the latter, with the variant if another one
      with the same equipment has that name.
    - `paper`: published distance [m]; `stated`: the `StatedDistance` of `_stated`, None without an accepted distance;
      `text`: the latter with its changes; `repeats`: repeats of the stop, None without any; `lots`: distances by lot of
      the sensors [m], empty if sensors have no errors; `needs_lots`: whether they have.
    - `reference`, `vs_sbc`, `vs_tuned`: as `reference`, `stated_vs_sbc` and `stated_vs_tuned` of
      `railgrip.report.frame`.
    - Keys of `_MAXIMA`: figures of the accepted run.
    """
    repeats = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
    rows: list[dict[str, Any]] = []
    for stop in campaign.stops:
        one, repeated, scenario = accepted.get(stop.name), repeats.get(stop.name), stop.scenario.resolved()
        own = repeated if repeated and one and repeated.belongs(stop.scenario.digest(), one.value) else None
        reference = campaign.reference_for(stop)
        rows.append(
            {
                "stop": stop.name, "place": stop.variants["scenario"].replace("_", " "),
                "equipment": stop.variants["equipment"], "variant": stop.variants["controller"],
                "controller": scenario["controller"]["kind"], "controller_label": label(scenario),
                "scenario": scenario, "paper": reference.distance if reference else math.nan,
                "stated": _stated(one, own), "repeats": repeated, "lots": own.lots if own else (),
                "needs_lots": isinstance(stop.scenario.sensors, SampledSensors),
            } | {key: getattr(one, key, None) for key in _MAXIMA.values()}
        )  # fmt: skip
    compared_with = references(rows, lambda row: row["scenario"], lambda row: row["stated"] and row["stated"].median)
    for row, others in zip(rows, compared_with, strict=True):
        row["reference"] = next((kind for kind, one in zip(_KINDS, others, strict=True) if one is row), None)
        changes = [_change(row["stated"], other["stated"]) if other and other is not row else None for other in others]
        row["vs_sbc"], row["vs_tuned"] = (math.nan if change is None else change for change in changes)
        row["text"] = _text(row["stated"], changes)
    frame = pandas.DataFrame(rows)
    labels, variants = frame["controller_label"], frame["variant"].str.replace("_", " ")
    namesakes = frame.groupby(["equipment", "controller_label"])["variant"].transform("nunique")
    return frame.assign(law=labels.where(namesakes == 1, labels + ", " + variants))


_KINDS: Final = ("published", "best tuned")
"""Kinds of slip-based control that others are compared with."""


def _stated(accepted: AcceptedValue | None, repeats: RepeatedDistances | None = None) -> StatedDistance | None:
    """Return the distances over the lots of sensors, or the accepted distance with its range; None without one."""
    if repeats and repeats.lots:
        return StatedDistance(repeats.lots, are_lots=True)
    if accepted is None:
        return None
    if not accepted.is_range:
        return StatedDistance((accepted.value,), math.nan if accepted.longest_lock is None else accepted.longest_lock)
    locks = repeats.figures.get("longest_lock", ()) if repeats else ()
    return StatedDistance((accepted.ends[0], accepted.value, accepted.ends[1]), max(locks, default=math.nan))


def _change(stated: StatedDistance | None, other: StatedDistance | None) -> float | None:
    return None if stated is None or other is None else stated.change_against(other)


def _wide(frame: Frame, first: str, row: str, column: str, values: str) -> ReportTable:
    """Return a table with a row and a column for each value of two columns, in their order; `first` is its heading."""
    table = frame.pivot(index=row, columns=column, values=values)
    table = table.reindex(index=frame[row].unique(), columns=frame[column].unique()).fillna("")
    return ReportTable.of_frame(table.rename_axis(first).reset_index(), left=(first,))


def tables(campaign: Campaign, baseline: Baseline) -> dict[str, ReportTable]:
    """Return the tables of accepted distances of a campaign with scenarios, equipment and controllers, by name.

    `distances` has a row for each equipment and controller, and a column for each scenario. Brackets contain the change
    against the published SBC, followed by the change against the best tuned SBC if there is one. A distance that
    depends on rounding, or on the lot of sensors, is given as median and range, with the longest lock in these runs.
    `runs` has the maximum adhesion, lock and strokes of the runs that were accepted. `orders` compares controllers in
    pairs, lot by lot. `discretisation` has the changes with a shorter communication step.

    Raises:
        ScenarioError: The repeats with other lots of sensors are missing, or belong to another stop.
    """
    frame = stops_of(campaign, baseline.accepted)
    stale = frame["stop"][frame["needs_lots"] & (frame["lots"].map(len) == 0)]
    if campaign.conditioning and len(stale):
        raise ScenarioError(
            f"{campaign.name}: there are no repeats with other lots of sensors of {names(stale.tolist())} as accepted; "
            "run `make conditioning`"
        )
    equipment = frame["equipment"].map(lambda one: _EQUIPMENT.get(one, one))
    frame = frame.assign(line=equipment + ": " + frame["law"])
    published = frame[frame["paper"].notna()]
    # The first one is the paper's SBC.
    first = published["place"].map(published.drop_duplicates("place").set_index("place")["paper"])
    published = published.assign(
        line="*published: " + published["controller_label"] + "*",
        text=[
            f"{metres:.1f} m" + _brackets([None if metres == of_sbc else metres / of_sbc - 1])
            for metres, of_sbc in zip(published["paper"], first, strict=True)
        ],
    )
    maxima = frame.groupby("line", sort=False)[list(_MAXIMA.values())].agg(lambda one: one.astype(float).max())
    forms = {"greatest adhesion": "{:.3f}", "longest lock": "{:.1f} s", "valve strokes": "{:.0f}"}
    return {
        "distances": _wide(pandas.concat([published, frame]), _FIRST, "line", "place", "text"),
        "runs": ReportTable.of_frame(
            maxima.set_axis(list(_MAXIMA), axis=1).rename_axis("single runs").reset_index(), forms, ("single runs",)
        ),
        "orders": _orders(frame),
        "discretisation": steps_table(campaign),
    }


_MAXIMA: Final = {
    "greatest adhesion": "adhesion_peak",
    "longest lock": "longest_lock",
    "valve strokes": "valve_strokes",
}
"""Column → key of an accepted value, the figure of one run, of which a row has the maximum."""


def _orders(frame: Frame) -> ReportTable:
    """Return the paired differences between each controller and the next better one, lot by lot, with 95 % intervals.

    A controller is called shorter only if the interval excludes 0.
    """
    places = frame["place"].unique()
    with_lots = frame[frame["lots"].map(len) > 0].pivot(index=["equipment", "law"], columns="place", values="lots")
    with_lots = with_lots.reindex(columns=places).dropna()
    medians = with_lots.map(lambda lots: math.log(float(np.median(lots)))).sum(axis=1)
    lots = with_lots.loc[medians.sort_values(kind="stable").index]
    rows = [
        {"controller": better, "compared with": other}
        | {
            place: _difference([a - b for a, b in zip(lots[place].iloc[n], lots[place].iloc[n + 1], strict=True)])
            for place in places
        }
        for n, ((_, better), (_, other)) in enumerate(itertools.pairwise(lots.index))
    ]
    return ReportTable(rows, left=("controller", "compared with"))


def _difference(differences: Sequence[float]) -> str:
    """Return the median of paired differences [m] with its interval, and the order that the interval supports."""
    interval = median_interval(differences)
    if interval is None:
        return ""
    low, high = interval
    order = "shorter" if high < 0 else "longer" if low > 0 else "not separated"
    return f"{with_interval(float(np.median(differences)), interval, '{:+.1f}', ' m')} {order}"


def steps_table(campaign: Campaign) -> ReportTable:
    """Return by how much half and a quarter of the communication step move the median of each distance.

    The half width of the 95 % interval of a change without any cause follows; larger changes are bold. Rows without
    repeats at divided steps are left out.
    """
    equipped = campaign.only(lambda stop: "equipment" in stop.variants)
    if not equipped.stops:
        return ReportTable([])
    frame = stops_of(equipped, {})
    moved = [_moved_by_steps(one) if one is not None and one.steps else None for one in frame["repeats"]]
    frame = frame.assign(line=frame["equipment"] + ": " + frame["law"], moved=moved)
    shown = frame[frame["line"].isin(frame["line"][frame["moved"].notna()])]
    return _wide(shown, "half, quarter step", "line", "place", "moved")


def _moved_by_steps(repeated: RepeatedDistances) -> str:
    texts: list[str] = []
    for divisor in sorted(repeated.steps):
        change, noise = repeated.moved_by_step(divisor), repeated.noise_of_step(divisor)
        texts.append(_bold(text(100 * change, "{:+.2f} %"), abs(change) > max(noise, _VISIBLE)))
    noise = max(repeated.noise_of_step(divisor) for divisor in repeated.steps)
    return f"{', '.join(texts)} (± {100 * noise:.2f} %)"


CONVERGENCE = "validation.md"
"""Page of docs/ with the table of tolerances of `CONVERGENCE_CAMPAIGNS`."""

CONVERGENCE_CAMPAIGNS = ("convergence", "convergence_trains")


def tolerances_table(*campaigns: Campaign) -> ReportTable:
    """Return the error of each distance over the tolerance of the plant's solver, against the tightest tolerance.

    Errors within the 95 % interval of an error without any cause are not significant; others are bold. The first column
    of errors is that of the plant's own tolerance; the last column is the range of all these stops. Stops without
    repeats at other tolerances are left out.
    """
    rows = [_errors_over_tolerance(stop, repeated) for stop, repeated in _repeated(campaigns, "tolerances")]
    return ReportTable(rows, {"tightest": "{:.2f} m"}, left=("stop",))


def _repeated(campaigns: Iterable[Campaign], key: str) -> Iterator[tuple[PlannedStop, RepeatedDistances]]:
    """Yield stops with their repeats, if these have distances under a key such as `tolerances`."""
    for campaign in campaigns:
        repeats = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
        for stop in campaign.stops:
            if (one := repeats.get(stop.name)) is not None and getattr(one, key):
                yield stop, one


def _errors_over_tolerance(stop: PlannedStop, repeated: RepeatedDistances) -> dict[str, Any]:
    loose_to_tight = sorted(repeated.tolerances, reverse=True)
    every = [d or math.inf for each in (repeated.distances, *repeated.tolerances.values()) for d in each]
    errors = {"as in the recipe": repeated.error_at(None)}
    errors |= {f"{tolerance:.0e}": repeated.error_at(tolerance) for tolerance in loose_to_tight[:-1]}
    tightest = np.median([d or math.inf for d in repeated.tolerances[loose_to_tight[-1]]])
    return {
        "stop": _name_of(stop),
        "tightest": float(tightest),
        **{
            column: _bold(f"{text(100 * error, '{:+.2f}')} ± {100 * noise:.2f} %", abs(error) > max(noise, _VISIBLE))
            for column, (error, noise) in errors.items()
        },
        "range": f"{min(every):.1f} – {max(every):.1f} m",
    }


def _bold(shown: str, is_bold: bool) -> str:
    return f"**{shown}**" if is_bold else shown


_VISIBLE = 5e-5
"""Relative change that two decimals of a per cent show."""


def tables_of_cases(campaign: Campaign, baseline: Baseline) -> dict[str, ReportTable]:
    """Return the accepted distances of a campaign with cases: a row for each case, a column for each controller."""
    frame = pandas.DataFrame(
        {
            "case": stop.variants["case"].replace("_", " "),
            "controller": label(stop.scenario.resolved()),
            "text": _text(_stated(baseline.accepted.get(stop.name)), []),
        }
        for stop in baseline.selection(campaign).stops
    )
    return {"distances": _wide(frame, "case", "case", "controller", "text")}


def with_distances(baseline: Baseline, results: Results) -> Baseline:
    """Return a baseline with the distances of results with FMUs of OpenModelica; ranges are extended by them.

    Raises:
        ScenarioError: All FMUs of the results are from the built-in compiler.
    """
    if not from_elsewhere(results.stops):
        raise ScenarioError(f"{results.name}: its FMUs are those of the built-in compiler; run `make regress-omc`")
    accepted = dict(baseline.accepted)
    for finding in findings_of(results).values:
        if (one := accepted.get(finding.name)) is not None and finding.value is not None:
            distance = round(finding.value, 3)
            known = (*(one.compilers.get("openmodelica", ()) if one.is_range else ()), distance)
            accepted[finding.name] = one.model_copy(update={"compilers": {"openmodelica": (min(known), max(known))}})
    return baseline.model_copy(update={"accepted": accepted})


def compilers_table(*accepted: tuple[Campaign, Baseline]) -> ReportTable:
    """Return the accepted distance of each stop, and its distances with OpenModelica's FMUs.

    A difference is that between the nearest ends of both ranges; above `ACROSS_COMPILERS` it is bold.
    """
    values = [
        (stop, one, one.compilers["openmodelica"])
        for campaign, baseline in accepted
        for stop in baseline.selection(campaign).stops
        if (one := baseline.accepted.get(stop.name)) is not None and one.compilers
    ]
    return _table_of_compilers(
        (_name_of(stop), _range_text(*one.ends), _range_text(*others), _apart(one.ends, others, one.value))
        for stop, one, others in values
    )


def _table_of_compilers(rows: Iterable[tuple[str, ...]]) -> ReportTable:
    return ReportTable.of(("stop", "built-in compiler", "OpenModelica", "difference"), rows)


def medians_table(*campaigns: Campaign) -> ReportTable:
    """Return the medians of repeated stops with the FMUs of both compilers, with their 95 % intervals.

    A difference is that between the nearest ends of both intervals; above `ACROSS_COMPILERS` it is bold.
    """
    rows: list[tuple[str, ...]] = []
    for stop, repeated in _repeated(campaigns, "compilers"):
        distances = repeated.distances, repeated.compilers["openmodelica"]
        ours, others = intervals = [median_interval(each) or (min(each), max(each)) for each in distances]
        shown = [
            with_interval(float(np.median(d)), i, "{:.1f}", " m") for d, i in zip(distances, intervals, strict=True)
        ]
        rows.append((_name_of(stop), *shown, _apart(ours, others, repeated.median)))
    return _table_of_compilers(rows)


def _name_of(stop: PlannedStop) -> str:
    return ", ".join(name.replace("_", " ") for name in stop.variants.values())


def _apart(first: tuple[float, float], second: tuple[float, float], size: float) -> str:
    """Return the gap between two ranges relative to a size, bold above `ACROSS_COMPILERS`."""
    apart = (second[0] - first[1] if second[0] > first[1] else min(second[1] - first[0], 0.0)) / size
    return _bold(text(100 * apart, "{:+.2f} %"), abs(apart) > ACROSS_COMPILERS)


def _range_text(low: float, high: float) -> str:
    return f"{low:.2f} m" if high - low <= SMOOTH else f"{low:.1f} – {high:.1f} m"


TABLES: Mapping[str, tuple[str, Callable[[Campaign, Baseline], dict[str, ReportTable]]]] = {
    "table1": ("validation.md", tables),
    "adverse": ("rail_models.md", tables_of_cases),
}
"""Baseline → page of docs/ that contains its tables, and the function that returns them by name."""


def _text(stated: StatedDistance | None, changes: Sequence[float | None]) -> str:
    """Return distance or median and range, the longest lock, and the changes against other stops."""
    if stated is None:
        return ""
    range_ = "" if stated.ends is None else ", {:.1f} – {:.1f} m".format(*stated.ends)
    return f"{stated.median:.1f} m{range_}{locked_text(stated.lock)}{_brackets(changes)}"


def _brackets(changes: Sequence[float | None]) -> str:
    texts = [percent(change) for change in changes if change is not None]
    return f" ({', '.join(texts)})" if texts else ""


BASELINE: Final = "table1"
"""Baseline whose distances are drawn."""
FILE: Final = "distances.svg"
"""Name of the figure in the folder of the pages."""

_WIDTH: Final = 6.67
"""Width of the figure [inches]: 640 pixels on a page, where 8.5 points are 11 pixels."""
_SHOWN: Final = ("ideal", "service")
"""Equipment in the figure."""
_LAWS: Final = ("adhesion_literal", "adhesion_based", "slope_seeking")
"""Laws of which the figure has the best one."""


def distances_figure(campaign: Campaign, baseline: Baseline) -> tuple[Figure, str]:
    """Return the figure of the accepted distances of a campaign, and its numbers as text.

    It has the SBC of the paper and the best tuned one, the law as published, the other law with the shortest stops in
    service, and the ideal bound, with ideal and service equipment. The title states the changes in service.
    """
    rows = stops_of(campaign.only(lambda stop: stop.variants["equipment"] in _SHOWN), baseline.accepted)
    rows = rows.dropna(subset="stated")
    rows = rows.assign(
        place=pandas.Categorical(rows["place"], rows["place"].unique()),
        origin=rows["equipment"],
        distance=[stated.median for stated in rows["stated"]],
    )
    laws = rows[(rows["origin"] == _SHOWN[-1]) & rows["controller"].isin(_LAWS) & rows["vs_sbc"].notna()]
    keys = ("controller_label", ["place"], "vs_sbc")
    best = laws[laws["controller_label"].isin(rank(on_common(laws, *keys), *keys).index[:1])]
    kept = rows[rows["reference"].notna() | rows["paper"].notna() | (rows["controller"] == "ideal_bound")]
    shown = rows[rows["controller_label"].isin([*kept["controller_label"], *best["controller_label"]])]
    published = shown[shown["paper"].notna()]
    published = published.assign(origin="published", distance=published["paper"])
    tuned = rows.loc[rows["reference"] == "best tuned", "controller_label"]
    plain = {name: f"{name.partition(',')[0]} with tuned thresholds" for name in tuned}
    drawn = pandas.concat([shown, published]).replace({"controller_label": plain})
    drawing = overview_figure(drawn, width=_WIDTH)
    drawing.suptitle(_message(best), x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    # So that a figure in a file can be compared with the accepted distances.
    return drawing, "\n".join(
        f"{one.stop}: {one.distance:.1f} m"
        + ("" if one.stated.ends is None else ", {:.1f} to {:.1f} m".format(*one.stated.ends))
        + ("" if math.isnan(one.paper) else f", paper {one.paper:.1f} m")
        for one in shown.itertuples()
    )


def _message(best: Frame) -> str:
    """Return the changes in service by the best law, in a sentence."""
    if best.empty:
        return ""
    against = {"vs_sbc": "slip-based control as published", "vs_tuned": "tuned slip-based control"}
    parts = []
    for column, name in against.items():
        low, high = (f"{-100 * choose(best[column]):.0f}" for choose in (max, min))
        if best[column].notna().all():
            parts.append(f"{low if low == high else f'{low} to {high}'} % shorter than {name}")
    return textwrap.fill(f"In service {best['controller_label'].iloc[0]} stops {' and '.join(parts)}", 80)
