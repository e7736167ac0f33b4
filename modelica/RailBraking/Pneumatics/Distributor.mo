within RailBraking.Pneumatics;
model Distributor "Distributor valve with relay: cylinder pressure from brake pipe pressure"
  extends Icons.Pneumatic;
  extends PartialDistributor;
equation
  share = 1;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -60}, {-40, 40}, {10, 40}, {30, 0}, {80, -50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<table border=\"1\">
<tr><th>position</th><th>filling to 95 %</th><th>release to 0.4 bar</th></tr>
<tr><td>P, passenger</td><td>3 to 5 s</td><td>15 to 20 s</td></tr>
<tr><td>R, rapid: as P, at a higher p_max or braked weight</td><td>3 to 5 s</td><td>15 to 20 s</td></tr>
<tr><td>G, goods</td><td>18 to 30 s</td><td>45 to 60 s</td></tr>
</table>
<p>
Limits of UIC 540 (5th edition, 2006; EN 15355), for one vehicle whose pipe is vented or filled at
once; the defaults are the middle of each range. R in two stages by speed is <a
href=\"modelica://RailBraking.Pneumatics.TwoStageDistributor\">TwoStageDistributor</a>.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Pneumatics.PartialDistributor\">PartialDistributor</a>.</p>
</html>"));
end Distributor;
