"""Sanders

Sanders in front of one or two wheelsets on a rail with leaves. A wheelset leaves a share of the sand for those
behind, so that friction rises along the train.
"""

import matplotlib.pyplot as plt

import railgrip as rg

sand = {"mu0": 0.2, "density": "6 g/m", "left": 0.85}
rail = {"kind": "constant", "polach": "leaf", "mu0": 0.03, "sand": sand}
places = {"none": [], "wheelset 1": [1], "wheelset 3": [3], "wheelsets 1 and 3": [1, 3]}

figure, (left, right) = plt.subplots(1, 2, layout="constrained", figsize=(8, 4))
for name, wheelsets in places.items():
    sanders = [{"wheelset": number, "rate": "2 kg/min", "delay": "1 s"} for number in wheelsets]
    changes = {"adhesion": rail, "sanders": sanders, "start.speed": "40 km/h"}
    stop = rg.run(rg.Scenario.load("plain", changes), controller="slip_three_state")
    left.plot(stop.trace["distance"], 3.6 * stop.trace["speed"], label=name)
    right.plot(stop.trace["wheelset"], stop.trace["mu0"].mean("time"), "o-")
left.set(xlabel="distance [m]", ylabel="speed [km/h]")
left.legend(title="sander at")
right.set(xlabel="wheelset", ylabel="mean friction mu0 [1]")
plt.show()
