within RailBraking.Interfaces;
connector BooleanOutput = output Boolean "Boolean output signal"
  annotation(
    Icon(graphics={Polygon(points={{-100, 100}, {100, 0}, {-100, -100}}, lineColor={255, 0, 255},
      fillColor={255, 255, 255}, fillPattern=FillPattern.Solid)}));
