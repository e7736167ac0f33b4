within RailBraking.Plants;
block TwoPartTrainPneumatic "Two-part train with valves that fill, hold and vent the cylinders"
  extends Icons.Vehicle;
  extends Vehicles.PartialTwoPartTrain;
  parameter Types.Time T_fill(min=1e-3) = 0.4 "Time constant of filling" annotation(Dialog(group="Brake"));
  parameter Types.Time T_vent(min=1e-3) = 0.2 "Time constant of venting" annotation(Dialog(group="Brake"));
  parameter Types.Time dead_fill(min=0, max=0.126) = 0.05 "Dead time of the fill valves"
    annotation(Dialog(group="Brake"));
  parameter Types.Time dead_vent(min=0, max=0.126) = 0.04 "Dead time of the vent valves"
    annotation(Dialog(group="Brake"));
  parameter Types.PressureRate rate_choked(min=1) = 15e5 "Fastest venting, through a choked valve"
    annotation(Dialog(group="Brake"));
  parameter Types.PressureRate leak(min=0) = 1e3 "Loss of pressure through leaks" annotation(Dialog(group="Brake"));
  parameter Types.Ratio hysteresis(min=0, max=0.5) = 0
    "Half width of the hysteresis of the calipers over the mean pad force" annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_reverse(min=1) = 1e4
    "Change of pressure in which the friction of the calipers reverses"
    annotation(Dialog(group="Brake"));
  Interfaces.RealInput valve_command[groups](each final unit="1", each start=0)
    "Valves of each group: -1 vent, 0 hold, 1 fill"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.ValveCylinder cylinder[groups](
    p_max=p_max, p_start=p_start, V=V_group, each p_free=p_free, each T_fill=T_fill, each T_vent=T_vent,
    each dead_fill=dead_fill, each dead_vent=dead_vent, each rate_choked=rate_choked, each leak=leak)
    "Cylinders of each group"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Pneumatics.HystereticRigging rigging[groups](
    each A_piston=A_piston, each i_rigging=i_rigging, each eta_rigging=eta_rigging, each F_spring=F_spring,
    each hysteresis=hysteresis, each p_reverse=p_reverse) "Rigging of each group"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
equation
  for i in 1:groups loop
    connect(valve_command[i], cylinder[i].command)
      annotation(Line(points={{-110, 0}, {-90, 0}, {-90, -60}, {-62, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, rigging[i].pressure)
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -60}, {18, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, cylinder_pressure[i])
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -30}, {90, -30}, {90, 26}, {110, 26}}, color={0, 0, 127}));
    connect(rigging[i].pad_force, pad_force[i])
      annotation(Line(points={{62, -60}, {95, -60}, {95, 18}, {110, 18}}, color={0, 0, 127}));
  end for;
  air_flow = sum(cylinder.air_flow);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Wheel-slide protection as in service: binary valves with dead time, see
<a href=\"modelica://RailBraking.Pneumatics.ValveCylinder\">ValveCylinder</a>. The thresholds of
<code>valve_command</code> are &plusmn;0.5. Hysteresis of the calipers is
off unless a scenario sets it.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a> and of the parts
named.</p>
</html>"));
end TwoPartTrainPneumatic;
