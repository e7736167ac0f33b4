within RailBraking.FMUs;
block ContactPoint "Adhesion of one wheelset at a given slip, speed, load and friction"
  extends Icons.Vehicle;
  parameter Types.Length r_wheel(min=1e-3) = 0.38 "Rolling radius of the wheels";
  parameter Types.Ratio k_A(min=0, max=1) = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S(min=0, max=1) = 0.1 "Polach: reduction of the creep stiffness in the area of slip";
  parameter Types.Ratio A_falling(min=0, max=1) = 0.4 "Polach: friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B_falling(min=0) = 0.2 "Polach: rate at which friction falls with slip speed";
  parameter Types.Length r_rail(min=1e-3) = 0.30 "Radius of the rail head across the track";
  parameter Types.Modulus E_steel(min=1e-3) = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu_steel(min=0, max=0.5) = 0.28 "Poisson's ratio of wheel and rail";
  Interfaces.RealInput slip(final unit="1", start=0) "Slip, 0 rolling, 1 locked"
    annotation(Placement(transformation(extent={{-120, 65}, {-100, 85}})));
  Interfaces.RealInput speed(final unit="m/s", start=20) "Speed of the wheelset along the track"
    annotation(Placement(transformation(extent={{-120, 15}, {-100, 35}})));
  Interfaces.RealInput load(final unit="N", start=137400) "Load of both wheels together, positive"
    annotation(Placement(transformation(extent={{-120, -35}, {-100, -15}})));
  Interfaces.RealInput mu0(final unit="1", start=0.3) "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-120, -85}, {-100, -65}})));
  Interfaces.RealOutput adhesion(final unit="1") "Force over load, positive in braking"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  final parameter Real factor = Contact.creepFactor(r_wheel, r_rail, E_steel, nu_steel)
    "Slope of epsilon, see creepFactor";
  Types.Ratio mu = Contact.fallingFriction(slip*speed, mu0, A_falling, B_falling) "Friction coefficient";
  Types.Ratio alpha = Contact.polach(slip, 0, load/2, mu, factor, k_A, k_S, 1, 0) "Adhesion by the law of the contact";
equation
  adhesion = alpha;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
For programs that need the contact alone, to compute peaks of adhesion or the ideal braking distance. It calls the same
<a href=\"modelica://RailBraking.Contact.polach\">polach</a> as the plants.
</p>
<h4>Limitations</h4>
<p>The slip is not regularised here. It has no states: the output responds at once.</p>
</html>"));
end ContactPoint;
