within RailBraking.Data;
record Totals "Sums over the wheelsets of an axle, a bogie, a car or a train"
  extends Icons.Record;
  Types.Force capacity "Force with which brakes and resistance hold the train at rest";
  Types.Power contact_power "Heat made between wheels and rails, a time";
  Types.Power pad_power "Heat made between pads and discs, a time";
  Types.Power damper_power "Heat made in the primary suspension, a time";
  Types.Power resistance_power "Power of bearing and rolling resistance; from the car on, of drag and track force too";
  Types.Energy kinetic_energy "Energy of rotation; from the car on, of motion along the track too";
  annotation (
    Documentation(info="<html>
<p>
Each level adds those below and what it has itself: a bogie the dampers, a car or train the car body.
</p>
</html>"));
end Totals;
