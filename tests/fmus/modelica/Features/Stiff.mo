within Features;
model Stiff "Robertson's chemical reaction: rates over nine decades"
  Real a(start=1, fixed=true);
  Real b(start=0, fixed=true, nominal=1e-4);
  Real c(start=0, fixed=true);
equation
  der(a) = -0.04*a + 1e4*b*c;
  der(b) = 0.04*a - 1e4*b*c - 3e7*b^2;
  der(c) = 3e7*b^2;
end Stiff;
