"""Estimate adhesion and pad friction from recordings of a simulated or real train.

A *recording* is an xarray data set on one even time grid (`recording`). It comes from a stop of the loop or from a
file, and has the inputs and outputs of a prediction under the prediction's names, arrays as scalars
`cylinder_pressure[1]`. True states of the plant, which the filter must not use, are in `true_<state>`, for `judge`
only.

    from railgrip.recording.samples import recording_of
    from railgrip.estimation.models import of_class
    from railgrip.estimation.run import Settings, estimate
    from railgrip.estimation.judgement import judge

    recorded = recording_of(
        {"pad_force": (force, "N"), "speed": (v, "m/s"), "wheelset_speed": (w, "rad/s")},
        period=0.01,
        truth={"pad_friction": (mu, "1"), "group_adhesion": (alpha, "1")},
    )
    prediction = of_class("RollerRigPrediction").prediction({"load": 98.1e3})  # any class of RailBraking.Predictions
    settings = Settings(
        # Densities, (unit of state)²/s.
        process={"speed": 1e-6, "wheelset_speed": 1e-4, "pad_friction": 2.5e-5, "group_adhesion": 1e-2},
        readings={"speed": 1e-8, "wheelset_speed": 1e-6},                     # variances
        start={"pad_friction": 0.35, "group_adhesion": 0.0},                  # speeds: from the first readings
        start_deviation={"speed": 0.1, "wheelset_speed": 0.3, "pad_friction": 0.04, "group_adhesion": 0.02},
    )
    estimates = estimate(recorded, prediction, settings)                      # xarray: mean, sd, innovation, nis
    estimates["mean"].sel(state="group_adhesion")
    judge(recorded, estimates, "pad_friction").rmse

Names without index in `Settings` apply to every element. `spec` reads the same from a TOML
file; `railgrip estimate FILE.toml` runs one, `railgrip observability FILE.toml` shows which states such a recording
determines. A new kind of source is one more table in `spec` with a function that returns a recording, registered in
`sources`.
"""
