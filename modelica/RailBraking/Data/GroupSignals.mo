within RailBraking.Data;
record GroupSignals "Signals of a group of wheelsets that turn as one"
  extends Icons.Record;
  Types.AngularVelocity w "Angular velocity";
  Types.Ratio slip "Slip, 0 rolling, 1 locked";
  Types.Ratio adhesion "Sum of braking forces over sum of loads";
  Types.Ratio pad_friction "Friction coefficient of the pads";
  Types.Temperature disc_temperature "Temperature of the bulk of the discs";
  Types.Temperature disc_surface_temperature "Temperature of the surface of the discs";
  Types.Torque brake_torque "Torque that the brake exerts";
  Boolean locked "= true, if the group is locked";
  annotation (
    Documentation(info="<html>
<p>
An <a href=\"modelica://RailBraking.Components.Axle\">Axle</a> has one; bogie, car and train hand on those of their
axles as they are.
</p>
</html>"));
end GroupSignals;
