within RailBraking.Vehicles;
function wheelsetPositions "Distance of each wheelset of a train of equal cars behind the leading one"
  extends Icons.Function;
  input Integer cars "Number of cars";
  input Integer bogies "Number of bogies of a car";
  input Integer axles "Number of wheelsets of a bogie";
  input Types.Length car_length "Length over couplers";
  input Types.Length pivots "Distance of the pivots of neighbouring bogies";
  input Types.Length wheelbase "Distance of the first and the last wheelset of a bogie";
  output Types.Length position[cars*bogies*axles] "Distances";
algorithm
  for c in 1:cars loop
    for b in 1:bogies loop
      for i in 1:axles loop
        position[axles*(bogies*(c - 1) + b - 1) + i] := (c - 1)*car_length + (b - 1)*pivots
          + (i - 1)*wheelbase/max(axles - 1, 1);
      end for;
    end for;
  end for;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127})}),
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
position = Vehicles.<strong>wheelsetPositions</strong>(cars, bogies, axles, car_length, pivots, wheelbase);
</pre></blockquote>
<h4>Limitations</h4>
<p>Wheelsets of a bogie have equal distances.</p>
</html>"));
end wheelsetPositions;
