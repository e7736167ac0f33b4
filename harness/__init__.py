"""Where plant, sensors, estimator and controller meet: scenarios, the loop, records and verdicts."""
