within RailBraking.Contact;
block WheelsetContact "The two contacts of one wheelset"
  parameter Types.Length r(start=0.38) "Rolling radius of the wheels";
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track";
  parameter Types.Curvature curvature_rail(min=0) = 0
    "Curvature of the rail along the track: none, or that of a roller";
  parameter Types.Modulus E = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu = 0.28 "Poisson's ratio of wheel and rail";
  parameter Types.Ratio k_A(start=0.3) "Reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S(start=0.1) "Reduction of the creep stiffness in the area of slip";
  parameter Types.Ratio A(start=0.4) "Friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B(start=0.2) "Rate at which friction falls with slip speed";
  parameter Types.Velocity v_small = 0.1 "Speed below which slip is regularised";
  final parameter Real factor = creepFactor(r/(1 + r*curvature_rail), r_rail, E, nu)
    "Slope of epsilon, see creepFactor";
  Interfaces.RealInput v(final unit="m/s") "Speed of the wheelset along the track"
    annotation(Placement(transformation(extent={{-120, 65}, {-100, 85}})));
  Interfaces.RealInput w(final unit="rad/s") "Angular velocity"
    annotation(Placement(transformation(extent={{-120, 15}, {-100, 35}})));
  Interfaces.RealInput load(final unit="N") "Load of both wheels together"
    annotation(Placement(transformation(extent={{-120, -35}, {-100, -15}})));
  Interfaces.RealInput mu0(final unit="1") "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-120, -85}, {-100, -65}})));
  Interfaces.RealOutput slip(final unit="1") "Slip, regularised"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput alpha(final unit="1") "Adhesion, positive in braking"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput F(final unit="N") "Force of the track on the wheelset, positive when it brakes the train"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput heat_flow(final unit="W") "Heat made in both contacts"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
protected
  final parameter Types.Force F_small = 100 "Rounding of the load about zero";
  Types.Force load_positive "Load, rounded to stay positive if the wheelset is unloaded";
equation
  slip = (v - r*w)/sqrt(v^2 + v_small^2);
  load_positive = (load + sqrt(load^2 + F_small^2))/2;
  alpha = polach(slip, v - r*w, load_positive/2, mu0, factor, k_A, k_S, A, B);
  F = alpha*load_positive;
  heat_flow = F*(v - r*w);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Ellipse(extent={{-50, 70}, {50, -30}}, lineColor={0, 0, 127}),
        Line(points={{-80, -30}, {80, -30}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Slip is (v - r w)/sqrt(v<sup>2</sup> + v_small<sup>2</sup>): at 1 m/s it is 0.5 % smaller than 1 - r w/v, at
standstill it is zero. Valid from rest to 60 m/s. Both wheels carry half of the load and have equal contacts.
</p>
<p>
On a roller the contact is that of a wheel of the radius 1/(1/r + <code>curvature_rail</code>) on a straight rail;
kinematics keep <code>r</code>.
</p>
<h4>Limitations</h4>
<p>
Below <code>v_small</code> a creeping wheel behaves like a very stiff damper; static friction is the business of
<a href=\"modelica://RailBraking.Components.Wheelsets\">Wheelsets</a> and
<a href=\"modelica://RailBraking.Components.TrainBody\">TrainBody</a>. The rounding of the load adds
F_small<sup>2</sup>/(4 load), less than 0.03 N for any railway wheelset.
</p>
</html>"));
end WheelsetContact;
