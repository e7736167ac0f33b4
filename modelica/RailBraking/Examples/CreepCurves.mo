within RailBraking.Examples;
model CreepCurves "Adhesion over slip of every named surface at 80 km/h"
  extends Icons.Example;
  parameter Types.Velocity v = 80/3.6 "Speed of the wheelset";
  parameter Types.Force Q = 68.7e3 "Load of a wheel";
  parameter Types.Time T = 1 "Time in which slip increases from zero to one";
  parameter Contact.Surfaces.Dry dry "Surface"
    annotation(Placement(transformation(extent={{-75, 38}, {-45, 68}})));
  parameter Contact.Surfaces.Wet wet "Surface"
    annotation(Placement(transformation(extent={{-35, 38}, {-5, 68}})));
  parameter Contact.Surfaces.LowAdhesion low "Surface"
    annotation(Placement(transformation(extent={{5, 38}, {35, 68}})));
  parameter Contact.Surfaces.LowAdhesionSteep steep "Surface"
    annotation(Placement(transformation(extent={{45, 38}, {75, 68}})));
  parameter Contact.Surfaces.VeryLow very_low "Surface"
    annotation(Placement(transformation(extent={{-75, -15}, {-45, 15}})));
  parameter Contact.Surfaces.MalDry mal_dry "Surface"
    annotation(Placement(transformation(extent={{-35, -15}, {-5, 15}})));
  parameter Contact.Surfaces.MalWet mal_wet "Surface"
    annotation(Placement(transformation(extent={{5, -15}, {35, 15}})));
  parameter Contact.Surfaces.MalPoor mal_poor "Surface"
    annotation(Placement(transformation(extent={{45, -15}, {75, 15}})));
  parameter Contact.Surfaces.MalWorst mal_worst "Surface"
    annotation(Placement(transformation(extent={{-75, -68}, {-45, -38}})));
  parameter Contact.Surfaces.BroadSoap soap "Surface"
    annotation(Placement(transformation(extent={{-35, -68}, {-5, -38}})));
  parameter Contact.Surfaces.BroadLeaf leaf "Surface"
    annotation(Placement(transformation(extent={{5, -68}, {35, -38}})));
  FMUs.ContactPoint point "The contact as a block, on the surface Wet"
    annotation(Placement(transformation(extent={{45, -68}, {75, -38}})));
  Types.Ratio slip "Slip, from zero to one";
  Types.Ratio alpha_dry "Adhesion on Dry";
  Types.Ratio alpha_wet "Adhesion on Wet";
  Types.Ratio alpha_low "Adhesion on LowAdhesion";
  Types.Ratio alpha_steep "Adhesion on LowAdhesionSteep";
  Types.Ratio alpha_very_low "Adhesion on VeryLow";
  Types.Ratio alpha_mal_dry "Adhesion on MalDry";
  Types.Ratio alpha_mal_wet "Adhesion on MalWet";
  Types.Ratio alpha_mal_poor "Adhesion on MalPoor";
  Types.Ratio alpha_mal_worst "Adhesion on MalWorst";
  Types.Ratio alpha_soap "Adhesion on BroadSoap";
  Types.Ratio alpha_leaf "Adhesion on BroadLeaf";
protected
  final parameter Real factor = Contact.creepFactor(0.38, 0.30, 2.1e11, 0.28) "Slope of epsilon, see creepFactor";
equation
  slip = time/T;
  point.slip = slip;
  point.speed = v;
  point.load = 2*Q;
  point.mu0 = wet.mu0;
  alpha_dry = Contact.polach(slip, slip*v, Q, dry.mu0, factor, dry.k_A, dry.k_S, dry.A, dry.B);
  alpha_wet = Contact.polach(slip, slip*v, Q, wet.mu0, factor, wet.k_A, wet.k_S, wet.A, wet.B);
  alpha_low = Contact.polach(slip, slip*v, Q, low.mu0, factor, low.k_A, low.k_S, low.A, low.B);
  alpha_steep = Contact.polach(slip, slip*v, Q, steep.mu0, factor, steep.k_A, steep.k_S, steep.A, steep.B);
  alpha_very_low = Contact.polach(
    slip, slip*v, Q, very_low.mu0, factor, very_low.k_A, very_low.k_S, very_low.A, very_low.B);
  alpha_mal_dry = Contact.polach(
    slip, slip*v, Q, mal_dry.mu0, factor, mal_dry.k_A, mal_dry.k_S, mal_dry.A, mal_dry.B);
  alpha_mal_wet = Contact.polach(
    slip, slip*v, Q, mal_wet.mu0, factor, mal_wet.k_A, mal_wet.k_S, mal_wet.A, mal_wet.B);
  alpha_mal_poor = Contact.polach(
    slip, slip*v, Q, mal_poor.mu0, factor, mal_poor.k_A, mal_poor.k_S, mal_poor.A, mal_poor.B);
  alpha_mal_worst = Contact.polach(
    slip, slip*v, Q, mal_worst.mu0, factor, mal_worst.k_A, mal_worst.k_S, mal_worst.A, mal_worst.B);
  alpha_soap = Contact.polach(slip, slip*v, Q, soap.mu0, factor, soap.k_A, soap.k_S, soap.A, soap.B);
  alpha_leaf = Contact.polach(slip, slip*v, Q, leaf.mu0, factor, leaf.k_A, leaf.k_S, leaf.A, leaf.B);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.0005),
    Documentation(info="<html>
<p>Slip increases with time. Peaks are between 0.4 % (MalWorst) and 16 % (BroadLeaf).</p>
</html>"));
end CreepCurves;
