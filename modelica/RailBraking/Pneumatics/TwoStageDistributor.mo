within RailBraking.Pneumatics;
model TwoStageDistributor "Distributor in position R whose relay has a high and a low stage, chosen by speed"
  extends Icons.Pneumatic;
  extends PartialDistributor;
  parameter Types.Ratio share_low(min=0, max=1) = 0.5 "Cylinder pressure of the low stage over that of the high one";
  parameter Types.Velocity v_up(min=0) = 70/3.6 "Speed at and above which the high stage is selected";
  parameter Types.Velocity v_down(min=0) = 50/3.6 "Speed below which the low stage is selected";
  parameter Types.Time T_stage(min=1e-3) = 0.3 "Time constant of the change from one stage to the other";
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, 60}, {-100, 80}})));
  Interfaces.BooleanOutput high(start=false, fixed=true) "= true, if the high stage is selected"
    annotation(Placement(transformation(extent={{100, -70}, {120, -50}})));
protected
  Types.Ratio stage(start=share_low, fixed=true, nominal=1) "Present share of the relay";
equation
  high = if pre(high) then speed >= v_down else speed >= v_up;
  T_stage*der(stage) = (if high then 1 else share_low) - stage;
  share = stage;
initial equation
  assert(v_down < v_up, "TwoStageDistributor: v_down must be below v_up, or the stage has no hysteresis.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -60}, {-40, 40}, {10, 40}, {30, 0}, {80, -50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The friction of cast-iron blocks rises as a train slows down: the pressure that they require at high
speed would lock wheels at low speed. In position R such vehicles brake with full pressure above
<code>v_up</code> and with
<code>share_low</code> of it below <code>v_down</code>; in between the stage does not change. Times
of filling and release are those of position P.
</p>
<p>
Not verified against the standards (UIC 540, UIC 541-1, EN 15355): changeover at 50 km/h and 70 km/h
and the share of the low stage are usual values. <code>T_stage</code> is estimated.
</p>
<h4>Limitations</h4>
<p>
A vehicle that starts to move, or a simulation that starts, between both speeds is in the low stage. What the relay
vents at a changeover goes to the atmosphere. Those of <a
href=\"modelica://RailBraking.Pneumatics.PartialDistributor\">PartialDistributor</a>.
</p>
</html>"));
end TwoStageDistributor;
