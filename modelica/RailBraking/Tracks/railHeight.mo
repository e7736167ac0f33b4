within RailBraking.Tracks;
function railHeight "Height of a wheelset on a rail whose height is a sum of waves"
  extends Icons.Function;
  input Types.Length x "Position";
  input Types.Length amplitude[:] "Amplitude of each wave";
  input Types.Curvature wavenumber[:] "Wavenumber of each wave";
  input Types.Angle phase[:] "Phase of each wave at position 0";
  output Types.Length upward "Height over that of an even rail";
algorithm
  upward := 0;
  for j in 1:size(amplitude, 1) loop
    upward := upward + amplitude[j]*cos(wavenumber[j]*x + phase[j]);
  end for;
  annotation (
    smoothOrder=100,
    Documentation(info="<html>
<p>The height is &Sigma; amplitude cos(wavenumber x + phase).</p>
<h4>Syntax</h4>
<blockquote><pre>
upward = Tracks.<strong>railHeight</strong>(x, amplitude, wavenumber, phase);
</pre></blockquote>
<h4>Limitations</h4>
<p>The wheelset does not leave the rail.</p>
</html>"));
end railHeight;
