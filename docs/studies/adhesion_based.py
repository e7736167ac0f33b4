# %% [markdown]
# # Adhesion-based maximum-seeking brake control
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# Schwarz, Posielek and Goetjes: Adhesion-Based Maximum-Seeking Brake Control for Railway Vehicles (2021). The paper
# compares slip-based control (SBC), which holds the slip between 10 and 15 %, with adhesion-based control (ABC), which
# seeks the slip of the greatest adhesion.
#
# The text of the paper was available, its images were not. Published values are therefore those that its text and Table
# 1 state. They are drawn as marks or words in the axes of our figures; no curve of the paper is digitised.
#
# The paper takes pad friction from Ehret (2021). Only the abstract of that model was available: it links relative
# velocity, temperatures and normal pressure of the contact surfaces to the instantaneous friction, with parameters
# identified on a full-scale dynamometer, and is verified by braking distances. Our [pad friction](../train_models.md)
# is a formulation of railgrip: it follows sliding speed, temperature of the disc and pad force, and settles over
# friction work as in the model of Ostermeyer (2003). It has neither measured parameters nor temperatures of the contact
# surfaces.
#
# ## Published and ours
#
# *chosen*: our number was chosen after the published one, so that their difference is not a result.

# %%
import numpy as np
import pandas as pd
import proof_terms
import published
import table1_stops as table1
from table1_stops import ABC, FITS, LAWS, LIMIT, PEAK_SEEKING, SBC, SCENARIOS, SPANS

import railgrip as rg
from railgrip.report import palette, style
from railgrip.report.table import percent, share
from railgrip.simulate.creep_curves import LOAD, SLIPS, SPEED, maxima

# %% tags=["parameters"]
quick = False

# %%
stops = rg.evaluate(table1.stop_row, table1.cases(quick), "adhesion_based.csv")
fit = FITS["identified"]
repeats = {scenario: table1.repeats_of(stops, "identified", scenario) for scenario in SCENARIOS}
on_trapezoid = repeats["trapezoid"]
seeds = {SBC: 0, ABC: table1.median_seed(on_trapezoid), PEAK_SEEKING: 0}
drawn = pd.DataFrame([{"law": law, "seed": seed} for law, seed in seeds.items()]).merge(
    stops[(stops["rail"] == "identified") & (stops["scenario"] == "trapezoid")]
)
drawn = {row.law: row for row in drawn.itertuples()}
perturbed = stops[stops["seed"] > 0].groupby(["rail", "law", "scenario"])
medians = perturbed["distance"].median().round(2)
speeds = [80] if quick else table1.SPEEDS
lines = [("leaves", causes, 80) for causes in table1.CAUSES]
lines += [
    (rail, "cleaning and heat", speed) for rail in table1.RAILS for speed in speeds if (rail, speed) != ("leaves", 80)
]
curves = rg.evaluate(
    table1.curve_rows,
    [dict(zip(("rail", "causes", "speed"), line, strict=True)) for line in lines],
    "adhesion_based_curves.csv",
)
curves = {line: curve["adhesion"].to_numpy() for line, curve in curves.groupby(["rail", "causes", "speed"])}
in_words = {scenario: scenario.replace("_", " ") for scenario in SCENARIOS}


def by_span(row):
    return " / ".join(f"{100 * getattr(row, f'used_{span}'):.0f} %" for span in SPANS)


# %%
compared = [
    f"Fig. 1 | slip of maxima, {rail}, {speed} km/h | two distinct maxima, no numbers | "
    + ", ".join(f"{100 * SLIPS[place]:.1f} %" for place in maxima(curves[rail, "cleaning and heat", speed]))
    for rail in table1.RAILS for speed in speeds
]  # fmt: skip
unperturbed = stops[(stops["law"] == SBC) & (stops["seed"] == 0) & stops["rail"].isin(["identified", "library"])]
for row in unperturbed.sort_values("rail", kind="stable").itertuples():
    rail = f"{in_words[row.scenario]}, {row.rail}" + (" level" if row.rail == "identified" else "")
    front, rear = row.mu0_front, row.mu0_rear
    minima = f"{front:.3f} to {rear:.3f} | {'' if rear > front else 'does not rise'}"
    compared.append(f"Fig. 3 | minimum of μ0 from front to rear, {rail} | rises | {minima}")
for law in (SBC, ABC):
    for scenario in SCENARIOS:
        paper, ours, found = table1.PUBLISHED[scenario, law], medians["identified", law, scenario], repeats[scenario]
        change = percent(ours / paper - 1)
        spread = f"{found['distance'].min():.1f} – {found['distance'].max():.1f} m"
        difference = f"{change}, *chosen*" if law == SBC else f"{change}, fitted; {spread}"
        name = f"{LAWS[law]}, {in_words[scenario]}, identified level"
        compared.append(f"Table 1 | {name} | {paper:.1f} m | {ours:.1f} m | {difference}")
locks = f"a wheelset locks above {table1.LOCK_SPEED:g} m/s for longer than {table1.LOCK:g} s"
for scenario, found in repeats.items():
    ours = f"{sum(found['lock'] > table1.LOCK)} of {len(found)}, longest {found['lock'].max():.1f} s"
    compared.append(f"Table 1 | {LAWS[ABC]}, {in_words[scenario]}, identified level: {locks} | | {ours}")
compared.append(
    f"Fig. 4 | begin of the last rise of μ0 | {table1.LAST_RISE:.1f} s | {drawn[SBC].rise:.1f} s | *chosen*"
)
for law in (ABC, PEAK_SEEKING):
    row, longer = drawn[law], drawn[SBC].duration - drawn[law].duration
    compared += [
        f"Fig. 4 | {LAWS[law]}: SBC takes longer by | 2.0 s | {longer:.1f} s | {percent(longer / 2 - 1)}",
        f"Fig. 4 | {LAWS[law]}: adhesion over the greatest possible, before / in / after 9 to 16 s | "
        f"very close / suboptimal / very close | {by_span(row)}",
        f"Fig. 4 | {LAWS[law]}: rms of fast changes of adhesion, before / after 25 s | "
        f"significant chattering after 25 s | {row.chatter_before:.4f} / {row.chatter_after:.4f}",
    ]
published.compare(compared)

# %% [markdown]
# ## Figure 1: adhesion over slip

# %%
alt = "Adhesion over slip: each cause alone, and wet rail and leaves at three speeds"
figure, panels = style.panels(10, 4.2, 1, 2, label=alt, sharey=True)
of_causes = {f"leaves, {causes}": (curves["leaves", causes, 80], *look) for causes, look in table1.CAUSES.items()}
of_rails = {
    f"{rail}, {speed} km/h": (curves[rail, "cleaning and heat", speed], color, table1.SPEEDS[speed])
    for rail, color in zip(table1.RAILS, (palette.BLUE, palette.BLACK), strict=True) for speed in speeds
}  # fmt: skip
for panel, lines in zip(panels, (of_causes, of_rails), strict=True):
    panel.axvspan(10, 15, color=palette.ORANGE, alpha=0.25, linewidth=0, label="held by slip-based control")
    for label, (adhesion, color, linestyle) in lines.items():
        panel.plot(100 * SLIPS, adhesion, color=color, linestyle=linestyle, label=label)
        for place in maxima(adhesion):
            panel.plot(100 * SLIPS[place], adhesion[place], "o", markersize=4, color=color, clip_on=False)
    style.legend(panel, loc="upper left")
causes = f"causes, {SPEED * style.KMH:.0f} km/h, wheelset 1"
style.dress(panels[0], x="slip [%]", y="adhesion", title=causes, xlim=(0, 100), ylim=(0, 0.26))
style.dress(panels[1], x="slip [%]", title="wet rail and leaves, wheelset 1", xlim=(0, 100))
figure

# %% [markdown]
# The paper shows qualitative curves for a wet rail and for leaves, after Mayer and Rasel (2020), and speaks of two
# distinct maxima. Polach's creep curve has one maximum. The second one has two causes in railgrip ([the
# rail](../rail_models.md#slip-heats-the-contact)): slip removes the film, which raises adhesion up to the locked wheel,
# and slip heats the contact, which lowers friction. With both, adhesion falls behind the first maximum, rises to a
# second one, and falls again before the wheel locks. The paper gives no numbers for their slips. Ours follow from a
# published rate of cleaning, from Polach's dry curve, and from estimates that the creep curves name. On the wet rail
# both maxima are about equally high, on leaves the second is higher.
#
# ## Figure 2: control system
#
# ![Block diagram of controller, plant, sensors and estimator](../architecture.svg)
#
# The scheme is that of the paper: plant and prediction are Modelica models, exchanged as FMUs; estimator and controller
# are not. In the paper these are written in Matlab. Here the estimator is written in C, and the laws are CasADi
# formulas from which C is generated. The block of sensors is an addition; in this comparison its readings are exact.
# [Architecture](../architecture.md) describes the loop in detail.
#
# ## Figure 3: maximum friction of the three test scenarios

# %%
print(style.picture("adhesion_based_3.png", "Maximum friction at each wheelset over time", table1.rail_figure))

# %% [markdown]
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# The figure shows trapezoid, sine sweep and random course of the library's scenarios, for Polach's dry curve. The text
# gives only one instant, the last rise of the trapezoid at about 25 s; the scenario has its rise there. It gives no
# levels, but bounds one: the limit of adhesion of 0.15 becomes active after the last rise, so that μ0 must exceed it
# there. That of the library does not; the identified rail does ([below](#table-1-from-distances-and-text)). It says
# that the minimum rises from the front to the rear wheelset. This holds in all three scenarios, also on the identified
# rails. In our model wheelsets clean the rail up to a certain friction (`recovered` of the scenario), which has the
# same level as the rest of the rail.
#
# ## Figure 4: adhesion of the first wheelset

# %%
alt = "Adhesion of wheelset 1 on the trapezoid with SBC, ABC (paper) and peak seeking"
print(style.picture("adhesion_based_4.png", alt, lambda: table1.adhesion_figure(seeds)))

# %% [markdown]
# The trapezoid with the identified creep curve: SBC and ABC (paper), the law as printed, above, SBC and railgrip's peak
# seeking below. "Greatest possible" is the peak of the creep curve at the speed of the respective stop. Because the
# stops have different speeds at the same time, there is one such line for each.
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# - *The stop.* The law as printed depends on errors as small as the solver's, so that the figure has the stop with the
#   median distance of the repeats, and each sentence below is judged in all of them.
# - *Duration.* SBC takes longer than the law as printed by nearly as much as published, see the table. Peak seeking
#   stops earlier than the law as printed.
# - *9 to 16 s.* The paper has less adhesion than possible in this span, and explains it by the coupling of the
#   wheelsets. Ours uses as much as before and after it. While friction rises, adhesion rises although slip is already
#   behind the maximum; the law takes this for an effect of the slip, and slip drifts until the rise ends. With a larger
#   rise at 9 s less adhesion is used in this span, but then the law often does not return: a locked wheel has neither a
#   rate of slip nor one of adhesion that tells it to release.
# - *After 25 s.* The law chatters more than before. The paper names three causes: slip reacts strongly to a brake
#   demand that is too high at low speed, because the speed is in its denominator; the limit of 0.15 becomes active and
#   vents the brake cylinder abruptly; and sliding mode control often chatters. The limit is active here, too. The share
#   of each cause was not measured.
#
# ## When slip stays bounded
#
# The paper proves that its law drives the adhesion to the maximum, with two restrictions: the friction does not change,
# and the slip stays in the concave part of the curve. On a real rail α depends on the slip s, the speed v and the
# friction μ0, so that eq. (12) reads in full
#
#     σ = ṡ (∂α/∂s ṡ + ∂α/∂v v̇ + ∂α/∂μ0 μ̇0),   μ̇0 = v ∂μ0/∂x + ∂μ0/∂t
#
# The paper drops the second term, and does not have the third. Where their sum is larger than the first term, the law
# cannot see the slope: it can drift beyond the maximum, and the sign of its switching function does not bound the slip.
# What does bound it is the release of the brake above `slip_vent`, in `adhesion_based` as in `slope_seeking`. It needs
# no estimate of adhesion, so that its error does not matter, but it must be early enough.
#
# **Theorem.** A group with torque T, load N, radius r and inertia J on a train that slows is released at slip s. Over a
# horizon H let
#
# - α ≥ q μ0(t) − λ (s' − s) for slips s' from s to b, where q is the adhesion over friction at s: no fall of the curve
#   is steeper than λ;
# - the torque be at most T₁ during the dead time τ of the vent valve, and fall at the rate R or faster afterwards;
# - μ̄ be the mean friction, and m the largest integral of μ̄ − μ0 over a part of the horizon.
#
# Let E₁ = T₁ − r N q μ̄ > 0, c = r/(J v), Λ = c r N λ and E_τ = E₁ exp(Λτ). If
#
#     R > Λ E_τ                                                                        authority > disturbance
#
# and t₁ = ln(R/(R − Λ E_τ))/Λ ends within the horizon, then
#
#     s(t) ≤ s + c (R t₁ − E₁)/Λ + c r N q m exp(ΛH)
#
# while the brake is released, if the right-hand side does not exceed b. If E₁ ≤ 0, the second term is absent.
#
# *Proof.* From the torque balance, ds'/dt ≤ c (T − r N α), because the train slows. Insert the first bound, and split
# μ0 into μ̄ and its deviation. Without the deviation the excess torque E = T − r N (q μ̄ − λ (s' − s)) obeys Ė ≤ ΛE up
# to τ and Ė ≤ ΛE − R afterwards. By the inequality it falls from E_τ on and is zero t₁ after τ; the slip rises by the
# integral of c E, the second term. The deviation enters a linear system whose response grows as exp(Λt): integration by
# parts bounds its effect by the third term. If the sum does not exceed b, the slip cannot leave the range in which the
# first bound holds. If the slip falls below s in between, the argument starts anew with less torque and less time. ∎
#
# [Certificate of bounded slip](certificate.md) evaluates this at every sample of stops of the type test, with the true
# rail of the next moments and the smallest b of a grid: how often there is a bound, whether slip exceeded it, and how
# often the law can see the slope. A reduced model of a wheelset with valves, integrated by another method on random
# rails, never exceeds the bound; without the change of friction it does.
#
# Where it does not hold:
#
# - *Steps of friction and curves that fall steeply*, those with heat and recovery among them: the fall is larger than
#   the authority of the brake, and a wheelset may lock before the valves have vented. Where slip cleans the rail,
#   friction is that which the wheelset met in the trace; more slip would clean more, so that the bound is careful.
# - *Short waves* do not matter to the bound, because only the integral m of the friction counts, but they hide the
#   slope from the law.
# - *Held valves and wrong speeds.* The theorem begins with the release. If a valve does not obey, or the estimated slip
#   is too small, the release does not come, and a wheelset locks although its samples are inside. The long lock of
#   `slope_seeking` in the small set is that of a held valve.
# - *Heat and hysteresis.* It assumes that heat does not lower the friction, that adhesion over friction does not rise
#   with friction, and that the rigging has no hysteresis. The cases include detailed mechanics and curves with heat,
#   which break these assumptions.
#
# The theorem bounds the slip; it does not state that the law finds the maximum. Beyond `slip_vent` both laws release
# whatever they estimate, so that it applies to both.
#
# ## Sentences of the paper about its results
#
# <!-- constants: docs/studies/table1_stops.py -->
# *Required*: the search accepted only fits with which the sentence holds in at least three quarters of the repeats.
# *Not required*: the search did not use it. *Chosen*: it holds because of how the scenarios are made. *Follows*: it
# follows from the six fitted distances, so that it does not check the fit. Sentences on the trapezoid are judged in
# each repeat of the stop with the law as printed and the identified numbers (next section), in the same stops whose
# median is the identified distance; *here* has medians, and *holds in* counts repeats.

# %%
holds, middle = table1.judged(on_trapezoid), on_trapezoid.median(numeric_only=True)
savings = [1 - medians["identified", ABC, scenario] / medians["identified", SBC, scenario] for scenario in SCENARIOS]
rises = unperturbed[unperturbed["rail"] == "identified"]
minima = ", ".join(f"{row.mu0_front:.3f} to {row.mu0_rear:.3f}" for row in rises.itertuples())
uses = by_span(middle)
slip_based = f"{100 * np.mean([getattr(drawn[SBC], f'used_{span}') for span in SPANS]):.0f} %"
sentences = [
    ("minimum of μ0 rises from front to rear in all scenarios", "chosen", minima,
     (rises["mu0_rear"] > rises["mu0_front"]).all()),
    ("ABC saves at least 8.8 %, by medians", "follows", " / ".join(f"{100 * saving:.1f} %" for saving in savings),
     min(savings) >= table1.SAVING),
    (f"adhesion very close to the greatest possible (at least {100 * table1.CLOSE:.0f} %) before 9 s and after 16 s",
     "required", f"{uses} before / in / after", "close"),
    (f"suboptimal from 9 to 16 s (by at least {100 * table1.SUBOPTIMAL:.0f} %)", "not required", uses, "suboptimal"),
    (f"no wheelset locks above {table1.LOCK_SPEED:g} m/s (for longer than {table1.LOCK:g} s)", "required",
     f"longest lock {middle['lock']:.2f} s", "unlocked"),
    (f"strict adherence to the limit of {LIMIT:g} (at most {table1.OVER:g} s above)", "required",
     f"{middle['over']:.2f} s above, greatest adhesion {middle['peak']:.3f}", "limited"),
    ("the limit becomes active after the last rise of μ0", "required",
     f"greatest adhesion {middle['peak']:.3f}", "active"),
    (f"significant chattering after 25 s (at least {table1.CHATTERING:g} times that before)", "required",
     f"{middle['chatter_before']:.4f} before, {middle['chatter_after']:.4f} after", "chattering"),
    ("SBC takes approximately 2 s longer ({:g} to {:g} s)".format(*table1.LONGER), "required",
     f"{middle['longer']:.2f} s", "longer"),
    (f"SBC has considerably lower adhesion than ABC (by at least {100 * table1.LOWER:.0f} %)", "follows",
     f"{slip_based} against {100 * middle['used']:.0f} %", "lower"),
    (f"other wheelsets are qualitatively similar (at least {100 * table1.SIMILAR:.0f} % used by each group)",
     "required", f"{100 * middle['lowest_group']:.0f} % in the lowest group", "similar"),
]  # fmt: skip
counts = {name: f"{count} of {len(holds)}" for name, count in holds.sum().items()} | {True: "yes", False: "no"}
table = pd.DataFrame(sentences, columns=["sentence", "in the search", "here", "holds in"])
table["holds in"] = table["holds in"].map(counts)
rg.table(table, left=["sentence", "in the search", "here"])

# %% [markdown]
# Repeats in which a sentence fails are mostly those in which a wheelset locks. The saving is larger than published,
# above all on the random rail; see the next section.
#
# ### The other wheelsets
#
# The paper shows the first wheelset and leaves out the others, "since they are qualitatively similar". The figure shows
# them for the law as printed; the table has the used share of the greatest possible adhesion, means over the spans that
# the text distinguishes:

# %%
alt = "Adhesion of wheelsets 2 to 6 on the trapezoid with SBC and ABC (paper)"
print(style.picture("adhesion_based_4_others.png", alt, lambda: table1.wheelset_figure(seeds)))

# %%
of_drawn = [{"law": law, "seed": seed} for law, seed in seeds.items()]
used = rg.evaluate(table1.wheelset_rows, of_drawn, "adhesion_based_wheelsets.csv")
used["text"] = [" / ".join(f"{100 * getattr(row, span):.0f} %" for span in SPANS) for row in used.itertuples()]
table = used.pivot(index="wheelset", columns="law", values="text")[list(LAWS)].rename(columns=LAWS)
table.index = [f"wheelset {number}" for number in table.index]
rg.table(table.reset_index(names="before 9 s / 9 to 16 s / 16 to 25 s"), left=["before 9 s / 9 to 16 s / 16 to 25 s"])

# %% [markdown]
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# Table and sentence have one criterion, adhesion over the peak of the creep curve up to the limit of 0.15. All groups
# have brakes that can demand the limit, so that no wheelset is kept from the greatest adhesion by its brake. In the
# library's train the wheelsets of the Jacobs bogie (3 and 4) are, on the better stretches of rail. The paper publishes
# no brake forces.
#
# ## Table 1 from distances and text
#
# <!-- constants: docs/studies/table1_stops.py -->
# The paper publishes neither its creep curve nor brake forces, filter and threshold of its law, and friction only as a
# figure. Free are here: four numbers of the creep curve, two of the law, four of the rails, the brake, and one level of
# friction for each scenario. Six distances and the sentences above are known. For each candidate the three levels are
# solved for, so that slip-based control stops as published; the three distances of the law as printed and the required
# sentences are fitted by the other eleven numbers. All of them are *calibrated*, on Table 1 and on the text; no
# distance is predicted. The first fit was set by hand, with smaller steps of friction, steeper curves and slower
# filters, until no wheelset locked; an evolution strategy went on from it. No command repeats this.
#
# The law chatters, so that each of its distances is the median of stops whose plant parameters are perturbed, three in
# the search, 21 on this page. The perturbation is 1e-5, the tolerance of the plant's solver: the error that it may
# make in a step. An earlier fit held under perturbations of 1e-7, and broke when the last digits of the solver changed.
# The sentences are judged in the same stops.
#
# <!-- constants: docs/studies/table1_stops.py -->
# The search accepts a fit only if its creep curve is like published ones, that is, k_S/k_A is in their range and
# adhesion at 15 % slip is at least 55 % of the greatest at 80 km/h (Polach's dry curve has 56 %), and if the sentences
# that are marked *required* above hold in three quarters of the stops, among them that no wheelset locks.
#
# [Published and ours](#published-and-ours) has the six distances, the range over the repeats, and the number of repeats
# in which a wheelset locks.
#
# What the fit needs, and what does not hold together:
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# - *Rail after the last rise, and brakes.* The highest friction of the library's trapezoid is below 0.15, and so are
#   its full brakes. Here both reach it. Earlier versions of this page had rails and brakes of this kind as a table, in
#   which the controllers kept the pressures of the library's train; its brakes were not those that the table named.
# - *Steps of friction.* With the steps of the library's trapezoid the law as printed locks wheelsets in most repeats.
#   Before the last rise they are smaller here, and slower: slip drifts during a rise, the more the larger it is, and
#   less the more steeply the creep curve falls. So B is twice that of Polach's dry curve, and A is larger, too: both
#   are beyond published sets.
# - *9 to 16 s.* The identified fit does not have less adhesion in this span, and the search did not require it.
# - *Random.* The saving on the random rail is larger than published. With more scatter of the friction the distance
#   grows, but by stops in which wheelsets lock; with the scatter of the table, less than half of the library's, one
#   does in a single repeat.
#
# <!-- constants: Schwarz, Posielek and Goetjes (2021) -->
# The printed law can produce about the published distances on this train, with most sentences at once. This does not
# show that these are the numbers of the paper: there are more free numbers than distances. Polach's curve at the low
# speed of the last rise reaches nearly μ0, so that 0.158 is enough for the limit to become active.

# %%
rows = [
    (name, *(f"{table1.value_of(one, name):.3g}" for one in (fit, table1.LIBRARY)), f"{low:.3g} – {high:.3g}",
     "at its bound" if table1.value_of(fit, name) in (low, high) else "")
    for name, (low, high) in table1.BOUNDS.items()
]  # fmt: skip
levels = "{:g} – {:g}".format(*table1.LEVELS)
rows += [(f"level, {in_words[scenario]}", f"{fit[scenario]:.3f}", "", levels, "solved for") for scenario in SCENARIOS]
rg.table(pd.DataFrame(rows, columns=["number", "identified", "library", "bounds", "remark"]), left=["number"])

# %%
figure, panel = style.panels(8, 3.8, label="Identified creep curve and the dry one")
friction = table1.mean_friction(fit)
for numbers, color, name, offset in (
    (fit, palette.BLUE, "identified", [(10, 1), (6, 6)]),
    (table1.LIBRARY, palette.GREY, "dry, library", [(10, 12), (6, -24)]),
):
    slips, curve = table1.SLIPS, table1.creep_curve(numbers, friction)
    best, part = int(np.argmax(curve)), table1.share_of(numbers, friction)
    panel.plot(100 * slips, curve, color=color, label=f"{name}, μ0 = {friction:.3f}")
    for place, words, shift in zip(
        ((100 * slips[best], curve[best]), (15, part * curve[best])),
        (f"{name}: {100 * slips[best]:.1f} %", f"{100 * part:.0f} % of the greatest"),
        offset,
        strict=True,
    ):
        panel.plot(*place, "o", color=color)
        panel.annotate(words, place, xytext=shift, textcoords="offset points", fontsize=8, color=color)
panel.axvspan(10, 15, color=palette.ORANGE, alpha=0.25, linewidth=0, label="slip-based control")
title = f"creep curves at {SPEED * style.KMH:.0f} km/h and {LOAD / 1e3:.0f} kN, mean friction of the trapezoid"
style.dress(panel, x="slip [%]", y="adhesion", title=title, xlim=(0, 50), ylim=(0, 1.1 * friction))
style.legend(panel, loc="upper right")
figure

# %% [markdown]
# These numbers were searched or solved for; *brake* is the adhesion that the full brake of each group demands at
# nominal pad friction (the library's motor bogies have the value in the table, its Jacobs bogie less), *contrast* the
# high over the low friction of the trapezoid before its last rise, *top* the friction after it, *ramp* in seconds,
# *deviation* that of the random friction. The distances also depend on quantities that the paper does not give and that
# were chosen without a search:

# %%
rg.table(table1.chosen())

# %% [markdown]
# ### Other fits
#
# The best candidates that were judged on all three rails, by three repeats except for the first one; a sentence fails
# that does not hold in three quarters of them. The six distances hardly distinguish them:

# %%
rows = []
for rail in dict.fromkeys(medians.index.get_level_values("rail")):
    share_held = table1.judged(table1.repeats_of(stops, rail, "trapezoid"))[list(table1.REQUIRED)].mean()
    errors = [abs(metres / table1.PUBLISHED[scenario, law] - 1) for (law, scenario), metres in medians[rail].items()]
    fails = ", ".join(share_held.index[share_held < table1.HOLDS]) or "none"
    metres = " / ".join(f"{medians[rail, ABC, scenario]:.0f}" for scenario in SCENARIOS)
    numbers = {name: f"{table1.value_of(FITS[rail], name):.3g}" for name in table1.BOUNDS}
    ours = {"largest error": f"{100 * max(errors):.1f} %", "ABC (paper) [m]": metres, "sentences that fail": fails}
    rows.append(numbers | ours)
rg.table(pd.DataFrame(rows), left=[])

# %% [markdown]
# The scenarios of the validation page keep Polach's dry shape, which is published. `railgrip campaign identified` runs
# the identified one: `identified_trapezoid`, `identified_sine_sweep` and `identified_random` have its creep curve,
# rails and brakes, the campaign the parameters of the law. Besides the six calibrated distances it shows predictions:
# peak seeking and the ideal bound. The creep curve `identified`, which the type test draws, is that of a first fit and
# stays as it is.
#
# ## Equations 3, 9 and 12 to 15: the proof along a stop
#
# <!-- constants: docs/studies/proof_terms.py -->
# The paper proves that its law drives adhesion to its maximum. With σ = ∂α/∂s and V = σ²/2, the law u = L sgn(ṡ α̇) is
# to have the sign of σ (13), so that V falls (15). The table says in how many samples of the stops of figure 4 each
# inequality is violated for wheelset 1, above 3 m/s and for slip from 0.002 to 0.5. Derivatives of the creep curve are
# central differences of the plant's contact model; rates are differences of the plant's outputs.

# %%
violated = rg.evaluate(proof_terms.violation_rows, of_drawn[1:], "adhesion_based_proof.csv")
violated.index = [f"{LAWS[row.law]}, friction {row.friction}" for row in violated.itertuples()]
table = violated.drop(columns=["law", "seed", "friction", "samples"]).map(
    lambda part: "no such u" if np.isnan(part) else share(part)
)
table.insert(0, "samples", violated["samples"].map("{:.0f}".format))
rg.table(table.T.reset_index(names="violated in"), left=["violated in"])

# %% [markdown]
# <!-- constants: docs/studies/proof_terms.py -->
# Slip at which σ̄ of equation 12 is zero with both of its terms, at medians of speed, load, friction, v̇ and |ṡ| while
# friction is constant:

# %%
offsets = rg.evaluate(proof_terms.offset_row, of_drawn[1:], "adhesion_based_offsets.csv").replace({"law": LAWS})
shares = {"peak at": "peak", "equilibrium, slip rises": "rising", "slip falls": "falling", "adhesion lost": "loss"}
table = offsets[["law", "rate"]].rename(columns={"rate": "median rate of slip"})
table = table.assign(**{title: 100 * offsets[name] for title, name in shares.items()})
forms = dict.fromkeys(shares, "{:.3f} %") | {"median rate of slip": "{:.2f} 1/s", "adhesion lost": "{:.4f} %"}
rg.table(table, forms)

# %% [markdown]
# - *Equation 3.* The paper states g_s < 0. With s = 1 − rω/v a higher pressure raises the slip, so that g_s > 0 in
#   every sample. The proof needs g_s > 0, too: with g_s < 0 and a concave curve equation 15 would give dV/dt > 0.
# - *Equations 12 and 13.* While friction of the rail is constant, the product of the rates nearly always has the sign
#   of σ with the law as printed. Where friction changes, equation 12 lacks the term ∂α/∂μ0 · dμ0/dt, which is then
#   often as large as the others, and the sign is wrong more often. On the library's trapezoid, whose steps are larger,
#   it is wrong so often that wheelsets lock. Peak seeking keeps slip nearly constant at the maximum, where both factors
#   are close to zero; the sign means little there.
# - *Offset of the equilibrium.* The paper notes that adhesion is very close to its maximum and not at it, by the term
#   ∂α/∂v v̇ of equation 12. The second table has the slips at which both terms cancel. The offset is small against the
#   oscillation of the law.
# - *Equation 15.* A pressure that follows equation 9 at once would make V fall wherever the creep curve is concave, and
#   only there; the paper limits its proof to this part. The law as printed switches later than equation 9 requires,
#   because its derivatives come from filters: u has the wrong sign in half of the samples, and V rises nearly as often.
#   So the law does not converge but oscillates about the maximum.
# - *Result.* Peak seeking does not reduce V more often. It stays close to σ = 0, where V is already near its minimum,
#   while friction is constant, and in half of the samples while friction changes: the last row shows how often adhesion
#   is not close to the greatest possible.
#
# [The law as printed](printed_law.md) compares distances with and without deflections (equations 6 and 7), and shows
# what the guards of the law change and in which stops laws exceed their limit of adhesion.
