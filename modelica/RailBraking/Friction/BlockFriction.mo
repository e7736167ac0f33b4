within RailBraking.Friction;
block BlockFriction "Blocks on the tread whose friction follows speed and block force"
  extends Icons.Component;
  extends Interfaces.PartialPadFriction(mu(start=mu_start, fixed=true, nominal=0.1));
  parameter Types.Force F_upper(min=1e-3) = 62.5e3 "k2, times the number of blocks that share pad_force";
  parameter Types.Force F_lower(min=1e-3) = 12.5e3 "k3, times the number of blocks that share pad_force";
  parameter Types.Velocity v_upper(min=1e-3) = 100/3.6 "k4";
  parameter Types.Velocity v_lower(min=1e-3) = 20/3.6 "k5";
  output Types.Ratio mu_steady "Steady friction at the present conditions";
protected
  Real rate(final unit="1/s") "Rate at which friction settles";
equation
  mu_steady = mu_nominal*(pad_force + F_upper)/(pad_force + F_lower)*(pad_speed + v_upper)/(pad_speed + v_lower)
    *(pad_force_nominal + F_lower)/(pad_force_nominal + F_upper)*(pad_speed_nominal + v_lower)
    /(pad_speed_nominal + v_upper);
  rate = sqrt(1/T_settle^2 + (pad_force*pad_speed/E_settle)^2)*pad_force^4/(pad_force^4 + F_release^4);
  der(mu) = rate*(mu_steady - mu);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<blockquote><pre>
mu_steady = k1 (F + k2)/(F + k3) (v + k4)/(v + k5)
</pre></blockquote>
<p>
Karwatzki's law of the friction of one block with the force F at the speed v, from Wende, Fahrdynamik des
Schienenverkehrs (2003). Instead of k1 the class has the friction <code>mu_nominal</code> at the nominal speed and
force.
</p>
<table border=\"1\">
<tr><th>blocks</th><th>k1</th><th>k2</th><th>k3</th><th>k4</th><th>k5</th></tr>
<tr><td>cast iron P6</td><td>0.024</td><td>62.5 kN</td><td>12.5 kN</td><td>100 km/h</td>
<td>20 km/h</td></tr>
<tr><td>cast iron P10</td><td>0.0308</td><td>62.5 kN</td><td>19.23 kN</td><td>100 km/h</td>
<td>20 km/h</td></tr>
<tr><td>composite K</td><td>0.055</td><td>200 kN</td><td>50 kN</td><td>150 km/h</td>
<td>75 km/h</td></tr>
</table>
<p>
Friction settles as that of <a href=\"modelica://RailBraking.Friction.PadFriction\">PadFriction</a>, over an amount of
friction work, and keeps its value with released blocks.
</p>
<h4>Limitations</h4>
<p>
Temperature and wet blocks have no effect. The parameters of PadFriction for its effects are ignored.
</p>
</html>"));
end BlockFriction;
