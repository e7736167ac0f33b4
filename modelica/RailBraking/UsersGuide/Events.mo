within RailBraking.UsersGuide;
class Events "Lock, release and standstill"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>
A brake is dry friction: at rest its torque balances the other torques, up to a maximum. Plants have
two kinds of Boolean state for that.
</p>
<p>
A group becomes <code>locked</code> when its angular velocity reaches zero while the brake is stronger than the track,
and turns again when the
track exceeds brake and resistance by <code>tau_small</code>. Between both thresholds its state is
kept, so that it cannot chatter.
The conditions are levels, not edges: a group that is released and locked again within one step of a solver is
detected as well.
</p>
<p>
The train comes to rest when it is slower than <code>v_rest</code> and brakes, resistance and adhesion can
hold the track force, and moves again when they no longer can. At rest all groups are locked and all
contact forces are zero.
</p>
<p>
At low speed the contact is stiff: its time constant is J v/(r<sup>2</sup> dF/ds), 1 to 8 ms at 22 m/s and a few
microseconds near rest. Plants need an
implicit solver. Prediction models have neither the contact nor events.
</p>
</html>"));
end Events;
