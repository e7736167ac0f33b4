"""The brake monitor: condition of the pad friction of each brake group over stops, with alarms.

One stop gives *evidence* (`evidence`): a Kalman filter over the readings estimates the friction of each group reduced
to nominal temperature, speed and pressure by the law of `RailBraking.Friction`. `watch` follows it over stops: index
with uncertainty, trend, alarm, and finds stops on disk. `life` simulates a train's stops to show how early and how
rarely it alarms.

Information in one stop: readings of the train determine the sum of all brake forces. Groups can be distinguished only
if their pressures differ, in a stop with wheel-slide protection, or in a *testing stop* that releases one group after
the other for two seconds (`life.demand_table`). The uncertainty of the evidence accounts for that; without such a
difference it is that of the prior and causes no alarm.
"""
