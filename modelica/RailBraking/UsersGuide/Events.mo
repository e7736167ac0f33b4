within RailBraking.UsersGuide;
class Events "Lock, release and rest"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>
A brake is dry friction: it holds with as much torque as it needs, up to what it has. Plants have two kinds of Boolean
state for that.
</p>
<p>
A group becomes <code>locked</code> when its angular velocity reaches zero while the brake is stronger than the track,
and turns again when the
track exceeds brake and resistance by <code>tau_small</code>. Between both thresholds it stays what it is, so that it
cannot chatter.
The conditions are levels, not edges: a group that is released and locked again within one step of a solver is caught
as well.
</p>
<p>
The train comes to rest when it is slower than <code>v_rest</code> and brakes, resistance and adhesion can hold the
track force, and leaves
when they no longer can. Then all groups are locked and all forces of the contact are zero.
</p>
<p>
Low speed makes the contact stiff: its time constant is J v/(r<sup>2</sup> dF/ds), 1 to 8 ms at 22 m/s and a few
microseconds near rest. Plants need an
implicit solver. Prediction models have neither the contact nor events.
</p>
</html>"));
end Events;
