within RailBraking;
package Examples "Realistic cases to run and modify"
  annotation (Documentation(info="<html>
<p>Each is an experiment with a stop time and a tolerance.</p>
</html>"));
end Examples;
