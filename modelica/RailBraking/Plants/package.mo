within RailBraking;
package Plants "Vehicles and test rigs as simulated"
  annotation (Documentation(info="<html>
<p>
Each block becomes an FMU for co-simulation. It takes the physics from
<a href=\"modelica://RailBraking.Vehicles\">Vehicles</a> and adds the brake cylinders and what fills them.
</p>
<p>
Every parameter has a value, because FMI demands a start value; a scenario may change it. To make a plant of your own,
extend one of these blocks with other values, or extend a partial block of <code>Vehicles</code>.
</p>
</html>"));
end Plants;
