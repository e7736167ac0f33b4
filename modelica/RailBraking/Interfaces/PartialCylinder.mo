within RailBraking.Interfaces;
partial block PartialCylinder "Brake cylinders of one group and their supply"
  extends Icons.Component;
  parameter Types.Pressure p_max(start=3.4e5) "Maximum pressure of the cylinders";
  parameter Types.Volume V(start=6e-3) "Volume of all cylinders and hoses of the group";
  parameter Types.Pressure p_start = 0 "Pressure at the start";
  parameter Types.Pressure p_free = 1.01325e5 "Absolute pressure at which free air is counted";
  RealInput command(start=0) "Command of the brake control, whose meaning the extending class defines"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealOutput pressure(final unit="Pa") "Pressure in the cylinders, above the atmosphere"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  RealOutput air_flow(final unit="m3/s") "Free air taken from the supply"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Free air is counted at the temperature of the cylinder: V &Delta;p / p_free.</p>
</html>"));
end PartialCylinder;
