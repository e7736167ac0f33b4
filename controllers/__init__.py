"""Wheel-slide control laws: from observations and estimates to demanded brake cylinder pressures.

Every law is an object with `decide(observation) -> demands`: one demanded pressure [Pa] per braked group. How a demand
becomes valve commands is the business of `railgrip.controllers.valves`, so that the same law drives an ideal pressure
actuator and a pneumatic one. The package knows neither plants nor FMUs nor the harness.
"""
