# %% [markdown]
# # Adhesion and brake friction on a roller rig
#
# Schwarz and Keck: Simultaneous Estimation of Wheel-Rail Adhesion and Brake Friction Behaviour, IFAC-PapersOnLine
# 53(2), 8470 (2020). The paper estimates adhesion and pad friction of one wheelset on a roller rig with an extended
# Kalman filter. Here the rig is a simulated plant, and two filters estimate: one with Q and R of the paper's equation
# (20), and one with noises that follow from sensors and physics. The paper takes its filter from Brembeck et al.
# (2014): an extended FMI 2.0 co-simulation interface, in which the prediction is a co-simulation FMU with inline
# integration. Here the prediction is a Model Exchange FMU by default, and the filter integrates it with the method of
# Runge and Kutta of fourth order.
#
# Tests: `harness/scenario/library/rig_slide.toml` and `rig_sand.toml`; filters:
# `harness/estimation/library/rig_paper.toml` and `rig_own.toml`.
#
# The text of the paper was available, its images were not. Published values are therefore those that its text states.
# They are drawn as marks, bounds or words in the axes of our figures; no curve of the paper is digitised. The demand,
# friction and protection of both tests were chosen after these statements, so that agreement of the inputs with them
# is not a result. The results are the errors of the estimates and how they depend on period and encoder.
#
# ## Published and ours
#
# *chosen*: our number was chosen after the published one, so that their difference is not a result.

# %%
import numpy as np
import published
import rig_tests as rig
from rig_tests import NOISE, PERIOD

import railgrip as rg
from railgrip.report.style import picture
from railgrip.report.table import percent, yes_no

# %% tags=["parameters"]
quick = False

# %%
periods, noises = ([PERIOD], [NOISE]) if quick else ([PERIOD, 10e-3, 20e-3], [NOISE, 1e-4, 3.2e-4])
cases = [{"test": "rig_slide", "period": period, "noise": noise} for period in periods for noise in noises]
found = rg.evaluate(rig.rows, [*cases, {"test": "rig_sand", "period": PERIOD, "noise": NOISE}], "roller_rig.csv")
tests = found[(found["period"] == PERIOD) & (found["noise"] == NOISE)]
tests = tests.assign(
    speed=3.6 * tests["speed"],
    early=(tests["short_end"] / 33 - 1).map(percent),
    outside_is=np.where(tests["outside"] <= 0.02, "within", "above"),
    longest_is=np.where(tests["longest"] <= 0.1, "within", "above"),
)
points = rg.evaluate(rig.slide_rows, [{"test": "rig_sand"}], "roller_rig_slide.csv")
of_points = points.assign(slip=100 * points["slip"]).groupby("part").first()
values = {part: of_points.loc[part] for part in ("peak", "released", "rolling")}
statements = """
Fig. 3 | point 1, greatest adhesion | no numbers | adhesion {peak.adhesion:.3f} at {peak.slip:.1f} % slip
Fig. 3 | point 2, brake released | no numbers | adhesion {released.adhesion:.3f} at {released.slip:.1f} % slip
Fig. 3 | point 3, rolling | no numbers | adhesion {rolling.adhesion:.3f} at {rolling.slip:.1f} % slip
Fig. 4 | initial speed | 120 km/h | {slide.speed:.0f} km/h | *chosen*
Fig. 4 | short brakings | 3 | {slide.short:.0f} | *chosen*
Fig. 4 | begin of the first short braking | 18.0 s | {slide.short_begin:.1f} s | *chosen*
Fig. 4 | end of the last short braking | 33.0 s | {slide.short_end:.1f} s | {slide.early}
Fig. 4 | begin of the stop braking | 42.0 s | {slide.stop:.1f} s | *chosen*
Fig. 4 | adhesion until 110 s, 5 % quantile | 0.020 to 0.050 | {slide.low:.3f} | *chosen*
Fig. 4 | adhesion until 110 s, 95 % quantile | 0.020 to 0.050 | {slide.high:.3f} | *chosen*
Fig. 4 | wrong start of adhesion corrected in, {name} | first few tenths of a second | {slide.settling:.3f} s
Fig. 4 | pad friction, {name} | rises from 110 s on | {slide.pads_begin:.3f} to {slide.pads_end:.3f}
Fig. 4 | pad friction, true | rises from 110 s on | {slide.true_begin:.3f} to {slide.true_end:.3f}
Fig. 4 | largest error of adhesion outside protection events, {name} | almost identical | {slide.outside:.4f}
Fig. 4 | rms error of adhesion from 110 s on, {name} | well approximated | {slide.late_rmse:.4f}
Fig. 4 | largest error of adhesion from 110 s on, {name} | well approximated | {slide.late_largest:.3f}
Fig. 4 | rms error of ω_W / v_x, {name} | no remarkable difference | {slide.omega:.1e} rad/s / {slide.v:.1e} m/s
Fig. 5 | initial speed | 200 km/h | {sand.speed:.0f} km/h | *chosen*
Fig. 5 | adhesion, 4 to 11 s, first peak | 0.100 | {sand.first_peak:.3f} | *chosen*
Fig. 5 | adhesion, 4 to 11 s, after the fall | 0.050 | {sand.after_fall:.3f} | *chosen*
Fig. 5 | adhesion, 4 to 11 s, after the release | 0.100 | {sand.after_release:.3f} | *chosen*
Fig. 5 | adhesion, 4 to 11 s, at last | 0.000 | {sand.at_last:.3f} | {sand.at_last:.3f}
Fig. 5 | slides with more than 10 % slip, 4 to 11 s | 1 | {sand.slides:.0f} | *chosen*
Fig. 5 | wrong start of adhesion corrected in, {name} | first few tenths of a second | {sand.settling:.3f} s
Fig. 5 | pad friction, {name} | rises from 55 s on | {sand.pads_begin:.3f} to {sand.pads_end:.3f}
Fig. 5 | pad friction, true | rises from 55 s on | {sand.true_begin:.3f} to {sand.true_end:.3f}
Fig. 5 | brake applications a second, slide / sand | fewer in the sanding test | {slide.rate:.2f} / {sand.rate:.2f}
Fig. 5 | the same with one protection in both | fewer in the sanding test | {slide.rate:.2f} / {sand.same_rate:.2f}
Fig. 5 | rms oscillation of pad friction, slide / sand | larger with sand | {slide.ripple:.4f} / {sand.ripple:.4f}
Fig. 6 | error of adhesion outside events, {name} | ≤ 0.0200 | {sand.outside:.4f} | {sand.outside_is}
Fig. 6 | longest error above 0.02, {name} | ≤ 0.100 s | {sand.longest:.3f} s | {sand.longest_is}
Fig. 6 | peaks above 0.02 as drawn / in all of the test, {name} | one | {sand.peaks} / {sand.excursions}
Fig. 6 | response of the protection, slide / sand | about 0.2 s | {slide.response:.2f} / {sand.response:.2f} s
"""
filters = [(rig.NAMES[name], rows.iloc[0], rows.iloc[1]) for name, rows in tests.groupby("filter", sort=False)]
published.compare(
    line.format(name=name, slide=slide, sand=sand, **values)
    for line in statements.strip().splitlines()
    for name, slide, sand in filters[: 2 if "{name}" in line else 1]
)

# %% [markdown]
# <!-- constants: Schwarz and Keck (2020); harness/scenario/library/rig_sand.toml -->
# - *Figure 4, inputs.* Valves take more than a tenth of a second, so that the brake is applied a little after the
#   demand. The third short braking ends a second earlier than published; the text gives only the span of all three.
# - *Figures 4 and 5, start.* The paper reports that the estimate of adhesion is wrong in the first few tenths of a
#   second, until the error of its start is corrected, but not what the start was. Here both filters assume an
#   adhesion of 0.1 while the wheelset rolls; two steps correct it. The Q of equation (20) allows this in each step,
#   so that the slower transient of the paper has a reason that its text does not state: another period, or other
#   errors of the start.
# - *Figures 4 and 5, pad friction.* The paper could not measure pad friction. Here the true value is known: both
#   filters follow its rise. In our model it rises during the whole stop, as the roller slows and the discs warm up,
#   not only from the instant that the paper names. The [pad friction](../train_models.md) of the plant is a
#   formulation of railgrip.
# - *Figure 5, adhesion.* Between 4 and 11 s there is one slide, as the text describes it. Friction, demand and the
#   threshold of release were chosen for it: a weak brake lets the slip rise slowly to the release. From 11 s on the
#   demand is higher.
# - *Figure 5, protection.* The text explains the less frequent interventions in the sanding test by the higher
#   adhesion of sand. In our tests the thresholds differ, too: 10 and 20 % slip in the sliding test, 2 and 40 % in the
#   sanding test. With 10 and 20 % in both tests the brake is still applied less often in the sanding test, but the
#   difference is smaller.
# - *Figure 4, errors.* The paper has no numbers for this test: both courses of adhesion are "almost identical", and
#   the fast changes from 110 s on are well approximated. Its 0.02 and 0.1 s are stated for the sanding test only.
# - *Figure 6.* The paper has one peak above 0.02 during wheel-slide protection. It does not state the span of this
#   figure; ours has 4 to 11 s, the span that the text describes with figure 5. In this slide our filters have none.
#   In the whole test they have more, all during protection, each corrected within two periods; the paper states 0.1
#   s. It compares this with a usual response of the protection of 0.2 s. Ours is the median time from the
#   intervention until the pad force has fallen to 1/e; it follows from the valves of railgrip.
#
# ## Figure 1: the wagon

# %%
rig.wagon_figure()

# %% [markdown]
# Forces and torques of equations 1 to 6, positive as drawn; in braking the longitudinal forces of the rail are
# negative. railgrip has this wagon as the plant `Wagon` and the six states of equation (13) as the prediction
# `WagonPrediction`.
#
# The prediction corrects three things in the printed equations:
#
# - *Equation (4).* Braking loads the front wheelset. As printed, the transfer of load by resistance and track has the
#   other sign.
# - *Equation (5).* Both wheelsets brake with α m g, not with half of it.
# - *Equation (12).* It repeats both, and neglects 2 h/a μ_W against 1. The prediction keeps this term.
#
# Errors of the filter in a stop of the wagon, with the corrections and as printed:

# %%
wagons = rg.evaluate(rig.wagon_row, [{"equations": name} for name in rig.WAGONS], "roller_rig_wagon.csv")
forms = {name: "{:+.4f}" if name.endswith("bias") else "{:.4f}" for name in wagons.columns[1:]}
rg.table(wagons.rename(columns={"equations": "equations (4), (5), (12)"}), forms)

# %% [markdown]
# As printed, the filter estimates about twice the adhesion, because half of the force has to explain the
# deceleration, and pad friction with it.
#
# ## Figure 2: the roller rig

# %%
rig.rig_figure()

# %% [markdown]
# The schematic drawing is ours; the paper shows a picture of the rig. The plant `RollerRig` has a wheelset on a
# roller whose drive imitates drag and mass of a wagon. Load cells in the cylinders give both contact forces and so
# the measured adhesion.
#
# ## Figure 3: why the filter must trust the wheel speed

# %%
rig.qualitative_figure(points)

# %% [markdown]
# The text describes three points. In point 2 the protection releases the brake; the wheelset accelerates, and
# adhesion goes back up to its peak in point 1. According to the paper, a filter that trusts its model of the wheelset
# more than the measured speed takes the acceleration for a fall of adhesion, as on the way from 1 to 3; it therefore
# sets R11 to the lower end of its range and Q11 to the upper end. The points of our sanding test are drawn on the
# creep curve at the instant of the release.
#
# The table tests this in our sanding test, with equation (20) except for R11 and Q11: as printed in the first row,
# then with the other ends of the paper's range, 1e-9 to 1e1:

# %%
trusts = [(1e-9, 1e1), (1e1, 1e1), (1e-9, 1e-9), (1e1, 1e-9), (1e-9, 1e-5)][: 1 if quick else None]
cases = [{"R11": reading, "Q11": process} for reading, process in trusts]
trusted = rg.evaluate(rig.trust_row, cases, "roller_rig_trust.csv")
rg.table(trusted, dict.fromkeys(("R11", "Q11"), "{:.0e}") | dict.fromkeys(trusted.columns[2:], "{:.4f}"))

# %% [markdown]
# The argument does not hold on the simulated rig. No choice misleads the filter, because with the other entries of
# equation (20) adhesion follows from the speed of the roller. A lower Q11 is even better than the printed one.
#
# ## Figure 4: sliding test

# %%
about = "Speeds, pad force, adhesion and pad friction in the sliding test"
print(picture("roller_rig_slide.png", about, lambda: rig.record_figure("rig_slide", *rig.run_of("rig_slide"))))

# %% [markdown]
# ## Figure 5: sanding test

# %%
about = "Speeds, pad force, adhesion and pad friction in the sanding test"
print(picture("roller_rig_sand.png", about, lambda: rig.record_figure("rig_sand", *rig.run_of("rig_sand"))))

# %% [markdown]
# ## Figure 6: adhesion over slip

# %%
about = "Adhesion over slip and its error in the sanding test"
print(picture("roller_rig_slip.png", about, lambda: rig.over_slip_figure(*rig.run_of("rig_sand"))))

# %% [markdown]
# Both filters in the first slide of figure 5. With equation (20) the estimate is noisier, because its Q makes the
# filter differentiate the speed of the roller.
#
# ## Errors of both filters
#
# Errors are against the simulated truth, after the start. "Outside events" is the largest error outside protection
# events; an event lasts while the protection holds the brake back and a tenth of a second longer. "Kept" says whether
# the accuracy that the paper states for the sanding test holds.


# %%
FIGURES = {
    "rmse": ("α rmse", "{:.4f}"), "bias": ("α bias", "{:+.4f}"), "largest": ("α largest", "{:.3f}"),
    "outside": ("outside events", "{:.4f}"), "longest": ("longest > 0.02", "{:.3f} s"), "kept": ("kept", yes_no),
    "nees": ("α NEES", "{:.2g}"), "pads_rmse": ("μ rmse", "{:.4f}"), "pads_bias": ("μ bias", "{:+.4f}"),
    "pads_nees": ("μ NEES", "{:.2g}"), "pads_sd": ("μ sd claimed", "{:.2g}"),
}  # fmt: skip


def errors_of(frame, *first):
    titles = {name: title for name, (title, _) in FIGURES.items()} | {"noise": "σ of v"}
    shown = frame.assign(period=[f"{1e3 * period:g} ms" for period in frame["period"]])
    shown = shown[[*first, "filter", *FIGURES]].rename(columns=titles)
    return rg.table(shown, dict(FIGURES.values()) | {"σ of v": "{:.1e} m/s"})


errors_of(tests, "test")

# %% [markdown]
# ## Period and encoder
#
# The paper names neither the sampling period of its rig nor the encoder of the roller, and equation (20) is a
# different filter at every period, because it states the covariance that is added in one step. The sliding test at
# other periods and with other encoders of the roller (1σ of its speed):

# %%
errors_of(found[found["test"] == "rig_slide"], "period", "noise")

# %% [markdown]
# ### Which rig fits equation (20) as printed
#
# <!-- constants: Schwarz and Keck (2020) -->
# Q and R as printed, with an encoder of the roller without an error, one as noisy as R says, and one that rounds to
# steps with that variance. The table has the median error of adhesion outside protection events, how many draws of
# noise or steps keep the accuracy that the paper states for its sanding test (0.02, and a larger error corrected
# within 0.1 s), and the Cramér-Rao bound: the deviation to which 0.1 s of readings with the noises of R determine
# adhesion.

# %%
periods = [30e-3] if quick else [5e-3, 10e-3, 12e-3, 16e-3, 20e-3, 30e-3]
cases = [{"test": test, "period": period} for test in rig.START_SPEED for period in periods]
fits = rg.evaluate(rig.fit_rows, cases, "roller_rig_fits.csv")
fits["error"] = [f"{row.outside:.4f}, kept {row.kept} of {row.draws}" for row in fits.itertuples()]
fits["period"] = [f"{1e3 * period:g} ms" for period in fits["period"]]
keys = ["test", "period", "bound"]
wide = fits.pivot_table(index=keys, columns="encoder", values="error", aggfunc="first", sort=False).reset_index()
columns = {"bound": "bound of 0.1 s"}
wide = wide[["test", "period", *rig.ENCODERS, "bound"]].rename(columns=columns)
rg.table(wide, {"bound of 0.1 s": "±{:.1e}"}, left=["test"])

# %% [markdown]
# <!-- constants: docs/studies/roller_rig.py -->
# In the sanding test, for which the paper states this accuracy, R as printed keeps it in all draws at 30 ms, and at
# 16 and 20 ms with an encoder of steps: rigs with such periods fit the paper. In the sliding test, for which the
# paper states no numbers, the same accuracy is our criterion, and R as printed keeps it in all draws at no period. At
# short periods the filter differentiates the noise that R states; from 20 ms on it is too slow even without noise.
# The sensors are not the reason, because the Cramér-Rao bound is far below these errors. The reason is the filter:
# its Q lets adhesion change by more than its own size in each step, so that the estimate follows from one difference
# of the roller's speed. With the encoder of the tests above, which is better than R states, the accuracy is kept in
# the sliding test at 5 and at 10 ms.
