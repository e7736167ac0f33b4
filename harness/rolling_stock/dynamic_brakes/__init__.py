"""Dynamic brakes of train files: one module for each kind, with its keys, its forces and its part of a plant.

Bases are `AxleBrake` and `RailBrake` of `railgrip.rolling_stock.brakes`.
"""
