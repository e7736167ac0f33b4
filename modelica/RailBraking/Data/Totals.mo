within RailBraking.Data;
record Totals "Sums over the wheelsets of an axle, a bogie, a car or a train"
  extends Icons.Record;
  Types.Force capacity "Force with which brakes and resistance hold the train at rest";
  Types.Power contact_power "Heat generated between wheels and rails per time";
  Types.Power pad_power "Heat generated between pads and discs per time";
  Types.Power damper_power "Heat generated in the primary suspension per time";
  Types.Power resistance_power
    "Power of bearing and rolling resistance; for cars and trains also of drag and track force";
  Types.Energy kinetic_energy "Energy of rotation; for cars and trains also of motion along the track";
  annotation (
    Documentation(info="<html>
<p>
Each level adds its own contribution to the sums of the levels below: a bogie the dampers, a car or train the car body.
</p>
</html>"));
end Totals;
