"""How far from its target a train stops: a driver, deceleration control, and deceleration control that manages adhesion."""
