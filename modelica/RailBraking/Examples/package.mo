within RailBraking;
package Examples "Realistic cases for a reader to run and change"
  annotation (Documentation(info="<html>
<p>Each is an experiment with a stop time and a tolerance.</p>
</html>"));
end Examples;
