within RailBraking;
package Plants "Vehicles and test rigs as simulated"
  annotation (Documentation(info="<html>
<p>
Each block becomes an FMU for co-simulation. It extends a vehicle of <a
href=\"modelica://RailBraking.Vehicles\">Vehicles</a> with brake cylinders and their supply.
</p>
<p>
Every parameter has a value, because FMI requires a start value; a scenario may change it. To make a plant of your own,
extend one of these blocks with other values, or extend a partial block of <code>Vehicles</code>.
</p>
</html>"));
end Plants;
