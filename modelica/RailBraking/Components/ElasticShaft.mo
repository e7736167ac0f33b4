within RailBraking.Components;
block ElasticShaft "Shafts that twist between the wheels and the brake discs"
  extends Icons.Component;
  extends Interfaces.PartialShaft;
  parameter Types.Ratio wheel_share(min=1e-3, max=0.999) = 0.7 "Share of the inertia that is that of the wheels";
  parameter Types.RotationalStiffness k = 6e6 "Stiffness of each wheelset between both wheels and the brake discs";
  parameter Types.RotationalDamping d = 400 "Damping of each wheelset";
protected
  Types.AngularVelocity w_tread(start=w_start, fixed=true, nominal=1) "Angular velocity of the wheels";
  Types.Angle twist(start=0, fixed=true, nominal=1e-3) "Angle of the wheels before the brake discs";
equation
  J_braked = (1 - wheel_share)*J_total;
  w_wheel = w_tread;
  der(twist) = w_tread - w;
  tau = n*(k*twist + d*(w_tread - w));
  wheel_share*J_total*der(w_tread) = tau_wheel - tau;
  energy = J_braked*w^2/2 + wheel_share*J_total*w_tread^2/2 + n*k*twist^2/2;
  loss = n*d*(w_tread - w)^2;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
All wheels are one inertia, brake discs and gear another, with a spring and a damper between them. With the defaults and
J_total = 110 kg m<sup>2</sup> for a wheelset they swing against each other at 81 Hz.
</p>
<h4>Limitations</h4>
<p>
Both wheels of a wheelset turn alike, so that the rail is the same under both. Stiffness, damping and share are
estimates.
</p>
</html>"));
end ElasticShaft;
