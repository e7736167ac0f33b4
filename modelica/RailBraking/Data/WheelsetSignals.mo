within RailBraking.Data;
record WheelsetSignals "Signals of a wheelset under a bogie frame"
  extends Icons.Record;
  Types.Force F "Braking force of the track";
  Types.Force load "Load on the rail";
  Types.Length deflection "Deflection of the primary suspension, change from static, compression positive";
  annotation (
    Documentation(info="<html>
<p>
A <a href=\"modelica://RailBraking.Components.Bogie\">Bogie</a> has one for each wheelset; car and train hand them on
as they are.
</p>
</html>"));
end WheelsetSignals;
