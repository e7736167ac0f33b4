within RailBraking.Interfaces;
partial block PartialPadFriction "Friction coefficient between the pads and the disc of one group"
  RealInput pad_force(final unit="N") "Normal force of both pads of one brake unit together";
  RealInput pad_speed(final unit="m/s") "Sliding speed of the pads";
  RealInput temperature(final unit="K") "Temperature of the disc";
  RealOutput mu(final unit="1") "Friction coefficient";
  annotation (Documentation(info="<html>
<p>One coefficient stands for all brake units of a group.</p>
</html>"));
end PartialPadFriction;
