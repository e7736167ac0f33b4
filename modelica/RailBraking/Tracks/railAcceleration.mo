within RailBraking.Tracks;
function railAcceleration "Upward acceleration of a wheelset on a rail whose height is a sum of waves"
  extends Icons.Function;
  input Types.Length x "Position";
  input Types.Velocity v "Speed along the track";
  input Types.Length amplitude[:] "Amplitude of each wave";
  input Types.Curvature wavenumber[:] "Wavenumber of each wave";
  input Types.Angle phase[:] "Phase of each wave at position 0";
  output Types.Acceleration upward "Curvature of the height times the square of the speed";
algorithm
  upward := 0;
  for j in 1:size(amplitude, 1) loop
    upward := upward - amplitude[j]*wavenumber[j]^2*v^2*cos(wavenumber[j]*x + phase[j]);
  end for;
  annotation (
    smoothOrder=100,
    Documentation(info="<html>
<p>The height is &Sigma; amplitude cos(wavenumber x + phase).</p>
<h4>Syntax</h4>
<blockquote><pre>
upward = Tracks.<strong>railAcceleration</strong>(x, v, amplitude, wavenumber, phase);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The wheelset does not leave the rail. The slope of the rail times the acceleration along the track is neglected: it is
smaller than the other part by the change of speed within a wave over the speed.
</p>
</html>"));
end railAcceleration;
