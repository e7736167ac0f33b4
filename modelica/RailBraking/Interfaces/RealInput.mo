within RailBraking.Interfaces;
connector RealInput = input Real "Real input signal"
  annotation(
    Icon(graphics={Polygon(points={{-100, 100}, {100, 0}, {-100, -100}}, lineColor={0, 0, 127},
      fillColor={0, 0, 127}, fillPattern=FillPattern.Solid)}));
