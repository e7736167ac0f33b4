package ForeignTrain "Somebody else's train: other names, other units, other physics"
  constant Real g(final unit="m/s2") = 9.81 "Acceleration of gravity";
  constant Real rpm(final unit="s.rev/(rad.min)") = 9.549296585513721 "Revolutions a minute in a radian a second";
  annotation (
    version="0.1.0",
    Documentation(info="<html>
<p>
A small library of its own, written as if by a house that thinks in bar, km/h, kN and revolutions a minute. It is
independent of <code>RailBraking</code>; the harness runs its FMU with a mapping table. It is an
example of how to use your own plant.
</p>
</html>"));
end ForeignTrain;
