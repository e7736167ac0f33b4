"""How far from its target a train stops: a driver, deceleration control, and one that manages adhesion."""
