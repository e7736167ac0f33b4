within RailBraking.Examples;
model TwoMaxima "Adhesion over slip at 80 km/h on rails with a film that slip removes and heats"
  extends Icons.Example;
  parameter Types.Velocity v = 80/3.6 "Speed of the wheelset";
  parameter Types.Force load = 137e3 "Load of the wheelset";
  parameter Types.Length r = 0.38 "Rolling radius of the wheels";
  parameter Types.Time T = 20 "Time in which slip goes from zero to one";
  Contact.CleaningContact wet(r=r, curve=Data.CreepCurve(k_A=0.3, k_S=0.1, A=0.4, B=0.8)) "Wet rail"
    annotation(Placement(transformation(extent={{-80, 20}, {-40, 60}})));
  Contact.CleaningContact leaves(
    r=r, curve=Data.CreepCurve(k_A=0.3, k_S=0.1, A=0.4, B=1), mu_clean=0.25) "Rail with leaves"
    annotation(Placement(transformation(extent={{-20, 20}, {20, 60}})));
  FMUs.HeatedContactPoint film(B_falling=0.8) "The film of the wet rail, which slip heats and leaves alone"
    annotation(Placement(transformation(extent={{40, 20}, {80, 60}})));
  Types.Ratio slip "Slip, from zero to one";
equation
  slip = time/T;
  wet.v = v;
  wet.w = (1 - slip)*v/r;
  wet.load = load;
  wet.mu0 = 0.15;
  leaves.v = v;
  leaves.w = (1 - slip)*v/r;
  leaves.load = load;
  leaves.mu0 = 0.06;
  film.slip = slip;
  film.speed = v;
  film.load = load;
  film.mu0 = 0.15;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Slip grows with time. <code>wet.alpha</code> has maxima near 3 % and 33 % slip, <code>leaves.alpha</code> near 2 % and
50 %; <code>film.adhesion</code> has one. The treads become warmer on the way, some 20 K in these 20 s.
</p>
</html>"));
end TwoMaxima;
