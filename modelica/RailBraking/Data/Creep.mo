within RailBraking.Data;
record Creep "Contact of wheels and rails, without the friction coefficient"
  extends Icons.Record;
  parameter Types.Ratio k_A(min=0, max=1) = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S(min=0, max=1) = 0.1 "Polach: reduction of the creep stiffness in the area of slip";
  parameter Types.Ratio A(min=0, max=1) = 0.4 "Polach: friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B(min=0) = 0.2 "Polach: rate at which friction falls with slip speed";
  parameter Types.Length r_rail(min=1e-3) = 0.30 "Radius of the rail head across the track";
  parameter Types.Curvature curvature_rail(min=0) = 0
    "Curvature of the rail along the track: zero, or that of a roller";
  parameter Types.Modulus E(min=1e-3) = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu(min=0, max=0.5) = 0.28 "Poisson's ratio of wheel and rail";
  parameter Types.Velocity v_small(min=1e-3) = 0.1 "Speed below which slip is regularised";
  annotation (
    Documentation(info="<html>
<p>
Parameters of <a href=\"modelica://RailBraking.Contact.WheelsetContact\">WheelsetContact</a>; the defaults are a wet
rail.
</p>
</html>"));
end Creep;
