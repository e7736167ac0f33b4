within RailBraking.UsersGuide;
class Conventions "Signs, names, units"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<ul>
<li>SI units, temperatures in kelvin, pressures above the atmosphere.</li>
<li>Speed and angular velocity are positive forward; slip is 1 - r w/v, adhesion is force over load; both are positive
in braking.</li>
<li>Deflections are positive in compression and count from the static position.</li>
<li>Pitch is positive nose-down, as in braking.</li>
<li>The normal force of a brake unit, <code>pad_force</code>, is that of both pads together.</li>
<li>Wheelsets 1 to 6 and groups 1 to 4 count from the leading end; group 1 has wheelsets 1 and 2, group 2 wheelset 3,
group 3 wheelset 4,
group 4 wheelsets 5 and 6.</li>
<li><code>m_wheelset</code> is the mass that a wheelset carries on the rail; <code>m_unsprung</code> is its own.</li>
<li>Symbols are used within the physics; at the interface of an FMU names are words, the same as in
the programs that use them.</li>
<li>One class has one file, except the short definitions of <a href=\"modelica://RailBraking.Types\">Types</a>.</li>
<li>Small numbers that round a corner are named <code>..._small</code>; those that a user might want to change are
parameters.</li>
</ul>
</html>"));
end Conventions;
