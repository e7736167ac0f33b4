within RailBraking.Components;
block MagneticTrackBrake "Magnets that are attracted to the rail and brake by friction on it"
  extends Icons.Component;
  parameter Real n_magnets(final unit="1", start=2) "Number of magnets of one bogie or car";
  parameter Types.Force F_attraction(start=66e3) "Force of attraction of one magnet";
  parameter Types.Ratio mu_stand = 0.2 "Friction at standstill";
  parameter Types.Ratio mu_fast = 0.08 "Friction at high speed";
  parameter Types.Velocity v_friction = 8 "Speed at which half of the fall of friction is reached";
  parameter Types.Velocity v_min = 0 "Speed below which it is switched off";
  parameter Types.Velocity v_max = 56 "Speed above which it is not switched on";
  parameter Types.Time delay = 0.3 "Time until the magnets are lowered";
  parameter Types.Time T = 0.1 "Time constant of the magnetic field";
  Interfaces.RealInput command "On at or above 0.5, else off"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput force(final unit="N") "Force on the vehicle, positive when braking"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Pneumatics.DelayLine lowering(delay=delay, final period=0.01) "Remaining time until the magnets are down"
    annotation(Placement(transformation(extent={{-60, 30}, {-20, 70}})));
protected
  Types.Ratio field(start=0, fixed=true, nominal=1) "Attraction relative to that of the full field";
  Types.Ratio mu "Friction";
equation
  lowering.u = noEvent(if command >= 0.5 and speed >= v_min and speed <= v_max then 1 else 0);
  der(field) = (noEvent(if speed >= v_min then lowering.y else 0) - field)/T;
  mu = mu_fast + (mu_stand - mu_fast)/(1 + noEvent(max(speed, 0))/v_friction);
  force = n_magnets*F_attraction*field*mu*noEvent(min(max(speed/0.1, -1), 1));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-70, 20}, {70, -20}}, lineColor={0, 0, 127}),
        Line(points={{-90, -30}, {90, -30}}, color={0, 0, 127}, thickness=1),
        Line(points={{-40, 60}, {-40, 20}}, color={0, 0, 127}),
        Line(points={{40, 60}, {40, 20}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<blockquote><pre>
force = n_magnets F_attraction field mu,   mu = mu_fast + (mu_stand - mu_fast)/(1 + v/v_friction)
</pre></blockquote>
<p>
Independent of adhesion: subtract the force from the track force of the car. Trams use it down to standstill,
trains above some 50 km/h only, so that
they come to rest without a jerk (v_min). Values are estimated: the attraction of a magnet is 40 to
70 kN for trams and about 80 to 100 kN for trains; the friction of steel on the rail is 0.2 or less
at walking pace and about 0.1 at 100 km/h.
</p>
<h4>Limitations</h4>
<p>
A command above v_max takes effect when the speed has fallen to v_max. Magnets neither unload wheels
nor clean the rail for following wheelsets, and neither wear nor a wet rail changes their friction.
</p>
</html>"));
end MagneticTrackBrake;
