"""Twins: simulated rigs and vehicles that are measured, scenario → recording.

A twin steps a plant FMU through `railgrip.fmu`, with whatever controls it, and returns a recording
(`railgrip.trace.samples`): readings with the noise of their sensors, drawn from the scenario's seed, and the
truth beside them. `plant` opens the FMU:

    with plant("RollerRig", inputs={"valve_command": "1", "mu0": "1"}, outputs={"speed": "m/s"},
               period=1e-3, parameters={"speed_start": 33.3}) as rig:
        outputs = rig.start(np.array([0.0, 0.1]))      # vectors in the order of the mappings, SI
        outputs = rig.step(np.array([1.0, 0.1]))

Arrays are given by their size: `{"mu0": ("1", 6)}` takes six elements of the vector.
"""
