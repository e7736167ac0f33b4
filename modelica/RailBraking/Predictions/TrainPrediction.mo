within RailBraking.Predictions;
block TrainPrediction "Two-part train as modelled by an estimator"
  extends Icons.Vehicle;
  extends Vehicles.PartialTwoPartPrediction(
    final n_bogies=3, final group_of_wheelset={1, 1, 2, 3, 4, 4},
    m_unsprung={1500, 1500, 1300, 1300, 1500, 1500}, m_frame={3500, 2800, 3500}, I_frame={2200, 2300, 2200},
    wheelbase={1.9, 2.65, 1.9}, final frame_height=fill(h_frame, 3), final rod_height=fill(h_rod, 3),
    final stiffness=fill(k_primary, 3), final damping=fill(c_primary, 3));
  parameter Types.Length h_frame = 0.55 "Height of the frames' centres of gravity over the rail";
  parameter Types.Length h_rod = 0.40 "Height of the traction rods over the rail";
  parameter Types.Stiffness k_primary = 2.4e6 "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c_primary = 2.4e4 "Damping of the primary suspension over one wheelset";
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Twenty-five states: v, w, mu_b, alpha, dz, ddz, in this order; equation (7) of Schwarz, Posielek and Goetjes. Free of
events. The adhesion of a group is that of both its wheelsets.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialTwoPartPrediction\">PartialTwoPartPrediction</a>.</p>
</html>"));
end TrainPrediction;
