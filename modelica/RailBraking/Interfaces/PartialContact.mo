within RailBraking.Interfaces;
partial block PartialContact "Contacts between a wheelset and its rails"
  extends Icons.Component;
  parameter Types.Length r(start=0.38) "Rolling radius of the wheels";
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track";
  parameter Types.Curvature curvature_rail(min=0) = 0
    "Curvature of the rail along the track: zero, or that of a roller";
  parameter Types.Modulus E = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu = 0.28 "Poisson's ratio of wheel and rail";
  input Data.CreepCurve curve "Shape of the creep curve";
  parameter Types.Velocity v_small = 0.1 "Speed below which slip is regularised";
  RealInput v(final unit="m/s") "Speed of the wheelset along the track"
    annotation(Placement(transformation(extent={{-120, 65}, {-100, 85}})));
  RealInput w(final unit="rad/s") "Angular velocity"
    annotation(Placement(transformation(extent={{-120, 15}, {-100, 35}})));
  RealInput load(final unit="N") "Load of both wheels together"
    annotation(Placement(transformation(extent={{-120, -35}, {-100, -15}})));
  RealInput mu0(final unit="1") "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-120, -85}, {-100, -65}})));
  RealOutput slip(final unit="1") "Slip, regularised"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  RealOutput alpha(final unit="1") "Adhesion, positive in braking"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  RealOutput F(final unit="N") "Force of the track on the wheelset, positive when it brakes the train"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  RealOutput heat_flow(final unit="W") "Heat generated in both contacts"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
One contact represents both wheels. <code>curve</code> is that of Polach's law, an input so that it
may change along the track; another law may ignore it and have parameters of its own.
</p>
</html>"));
end PartialContact;
