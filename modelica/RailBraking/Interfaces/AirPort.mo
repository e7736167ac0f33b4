within RailBraking.Interfaces;
connector AirPort "Compressed air"
  Types.Pressure p "Pressure above the atmosphere";
  flow Types.VolumeFlow q "Free air that flows into the component";
  annotation(
    Icon(graphics={Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 127, 127},
      fillColor={0, 127, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected ports have the same pressure, and the flows into their components add up to zero. Air is
counted as free air, in m&sup3; at 1.01325 bar, like the air consumption of plants. Temperature is
constant: a volume V takes
V/p_free dp/dt. A port that is not connected is closed.
</p>
<h4>Limitations</h4>
<p>Two volumes must not be connected directly, but through a flow resistance.</p>
</html>"));
end AirPort;
