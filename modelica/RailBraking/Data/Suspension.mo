within RailBraking.Data;
record Suspension "Bogie frame and primary suspension, without masses and wheelbase"
  extends Icons.Record;
  parameter Types.Length h_frame = 0.55 "Height of the frame's centre of gravity over the rail";
  parameter Types.Length h_rod = 0.40 "Height of the traction rod over the rail";
  parameter Types.Stiffness k = 2.4e6 "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c = 2.4e4 "Damping of the primary suspension over one wheelset";
  annotation (
    Documentation(info="<html>
<p>
Parameters of <a href=\"modelica://RailBraking.Components.BogieFrame\">BogieFrame</a> that bogies of one kind share.
</p>
</html>"));
end Suspension;
