within RailBraking.Tracks;
function railRate "Upward speed of a wheelset on a rail whose height is a sum of waves"
  extends Icons.Function;
  input Types.Length x "Position";
  input Types.Velocity v "Speed along the track";
  input Types.Length amplitude[:] "Amplitude of each wave";
  input Types.Curvature wavenumber[:] "Wavenumber of each wave";
  input Types.Angle phase[:] "Phase of each wave at position 0";
  output Types.Velocity upward "Slope of the rail times the speed";
algorithm
  upward := 0;
  for j in 1:size(amplitude, 1) loop
    upward := upward - amplitude[j]*wavenumber[j]*v*sin(wavenumber[j]*x + phase[j]);
  end for;
  annotation (
    smoothOrder=100,
    Documentation(info="<html>
<p>The time derivative of <a href=\"modelica://RailBraking.Tracks.railHeight\">railHeight</a>.</p>
<h4>Syntax</h4>
<blockquote><pre>
upward = Tracks.<strong>railRate</strong>(x, v, amplitude, wavenumber, phase);
</pre></blockquote>
<h4>Limitations</h4>
<p>The wheelset does not leave the rail.</p>
</html>"));
end railRate;
