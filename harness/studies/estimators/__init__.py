"""How well adhesion, pad friction and speed can be known: estimators on the same recordings of simulated stops."""
