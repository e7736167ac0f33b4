within RailBraking.Tracks;
block UnevenRail "Rail whose height has a published spectrum"
  extends Icons.Component;
  extends Interfaces.PartialRail;
  parameter Real roughness(final unit="m", min=0) = 10.80e-7 "Factor of the spectrum; 4.032e-7 is low disturbance";
  parameter Integer lines(min=1) = 16 "Number of waves" annotation(Evaluate=true);
  parameter Types.Length longest(min=1e-3) = 125 "Longest wavelength";
  parameter Types.Length shortest(min=1e-3) = 1.25 "Shortest wavelength";
protected
  constant Types.Ratio pi = 3.14159265358979 "Circumference over diameter";
  constant Types.Ratio golden = 0.618033988749895 "Fractional part of the golden ratio";
  final parameter Types.Curvature corner = 0.8246 "Wavenumber above which the spectrum falls with its fourth power";
  final parameter Types.Curvature corner_long = 0.0206 "Wavenumber below which the spectrum is constant";
  final parameter Types.Ratio step = (longest/shortest)^(1/lines) "Ratio of two successive wavenumbers";
  final parameter Types.Curvature wavenumber[lines] = {2*pi/longest*step^(j - 0.5) for j in 1:lines}
    "Wavenumber of each wave";
  final parameter Types.Length amplitude[lines] = {sqrt(
    2*roughness*corner^2/((wavenumber[j]^2 + corner_long^2)*(wavenumber[j]^2 + corner^2))
    *wavenumber[j]*(sqrt(step) - 1/sqrt(step))) for j in 1:lines} "Amplitude of each wave";
  final parameter Types.Angle phase[lines] = {2*pi*(j*golden - floor(j*golden)) for j in 1:lines}
    "Phase of each wave at position 0";
  Types.Length x(start=0, fixed=true, nominal=1) "Distance travelled";
equation
  der(x) = v;
  for i in 1:n loop
    height[i] = railHeight(x - behind[i], amplitude, wavenumber, phase);
    rate[i] = railRate(x - behind[i], v, amplitude, wavenumber, phase);
    acceleration[i] = railAcceleration(x - behind[i], v, amplitude, wavenumber, phase);
  end for;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The height of the rail is a sum of cosines over the position, with the one-sided spectrum of ERRI B176, high
disturbance: S(k) = roughness corner&sup2;/((k&sup2; + corner_long&sup2;)(k&sup2; + corner&sup2;)) over the
wavenumber k. Wavenumbers are in geometric progression, so that their sum does not repeat, and the phases are
multiples of the golden ratio: all stops run on the same track.
</p>
<h4>Limitations</h4>
<p>
The rail is the same under both wheels and does not yield: forces above some 20 Hz, of the unsprung mass on the
stiffness of track and contact, are not modelled. Waves shorter than <code>shortest</code>, joints and switches
are missing.
</p>
</html>"));
end UnevenRail;
