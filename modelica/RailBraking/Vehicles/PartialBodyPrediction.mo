within RailBraking.Vehicles;
partial block PartialBodyPrediction "All masses of a train along the track, without the forces on them"
  extends Icons.Vehicle;
  parameter Types.Mass m(min=1e-3) = 84000 "Mass of the whole train, without rotating masses";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient";
  parameter Types.Area A_drag = 10 "Frontal area";
  parameter Types.Density rho_air = 1.2 "Density of the air";
  Types.Velocity v(start=22, fixed=true, nominal=1, stateSelect=StateSelect.always) "Speed of the train";
protected
  Types.Acceleration disturbance = 0 "Acceleration by forces in no other equation";
  Types.Acceleration a "Acceleration of the train";
  Types.Force thrust "Force on the train except drag, forward";
equation
  a = (thrust - rho_air/2*c_drag*A_drag*v^2)/m + disturbance;
  der(v) = a;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>One mass: couplers are rigid.</p>
</html>"));
end PartialBodyPrediction;
