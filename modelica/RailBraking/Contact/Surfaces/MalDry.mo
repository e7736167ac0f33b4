within RailBraking.Contact.Surfaces;
record MalDry "Dry rail of Mal et al."
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.46, A=0.4, B=0.6);
  annotation (Documentation(info="<html>
<p>Mal et al., extended Kalman filter for wheel-rail adhesion, table of the contact conditions (see References). k_A = k_S = 1 has no loss of stiffness: peaks lie at a very small slip.</p>
</html>"));
end MalDry;
