"""The brake monitor: from stop to stop, how healthy the friction of each brake group is, and when to look after it.

One stop gives *evidence* (`evidence`): a Kalman filter over the readings estimates the friction of each group reduced
to nominal temperature, speed and pressure by the law of `RailBraking.Friction`. `watch` follows it over stops: index
with uncertainty, trend, alarm. `life` simulates a train's stops to show how early and how rarely it alarms. `folder`
finds stops on disk, `page` draws.

What one stop can show: readings of the train show the sum of all brake forces. The groups are distinguished only when
their pressures move apart, in a stop with wheel-slide protection, or in a *testing stop* that releases one group after
the other for two seconds (`life.demand_table`). The uncertainty of the evidence says which it was; without such a
difference it stays that of the prior and no alarm is drawn from it.
"""
