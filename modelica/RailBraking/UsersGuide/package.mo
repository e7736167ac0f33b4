within RailBraking;
package UsersGuide "User's Guide"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>Plants and prediction models of railway braking at low adhesion.</p>
<ul>
<li><a href=\"modelica://RailBraking.UsersGuide.Overview\">Overview</a>: structure of the library</li>
<li><a href=\"modelica://RailBraking.UsersGuide.Conventions\">Conventions</a>: signs, names, units</li>
<li><a href=\"modelica://RailBraking.UsersGuide.Events\">Events</a>: lock, release and standstill</li>
<li><a href=\"modelica://RailBraking.UsersGuide.References\">References</a></li>
<li><a href=\"modelica://RailBraking.UsersGuide.ReleaseNotes\">Release Notes</a></li>
</ul>
</html>"));
end UsersGuide;
