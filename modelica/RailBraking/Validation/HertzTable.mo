within RailBraking.Validation;
model HertzTable "Semi-axes and creep stiffness of the contact against tabulated values"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=0.01);

  parameter Types.Force Q[3] = {65.7e3, 69.2e3, 71.1e3} "Loads of a wheel";
  parameter Types.Length a_exact[3] = {5.69e-3, 5.79e-3, 5.85e-3} "Semi-axes along the track by elliptic integrals";
  parameter Types.Length b_exact[3] = {4.86e-3, 4.95e-3, 4.99e-3} "Semi-axes across the track by elliptic integrals";
  parameter Types.Force slope_exact[3] = {9.78e6, 10.12e6, 10.31e6} "G a b c11 with c11 from Kalker's table";
  Types.Length a1 "Semi-axis along the track at the first load";
  Types.Length b1 "Semi-axis across the track at the first load";
  Types.Length a2 "Semi-axis along the track at the second load";
  Types.Length b2 "Semi-axis across the track at the second load";
  Types.Length a3 "Semi-axis along the track at the third load";
  Types.Length b3 "Semi-axis across the track at the third load";
  Types.Force slope[3] "G a b c11";
equation
  (a1, b1) = Contact.hertz(Q[1], 0.38, 0.30, 2.1e11, 0.28);
  (a2, b2) = Contact.hertz(Q[2], 0.38, 0.30, 2.1e11, 0.28);
  (a3, b3) = Contact.hertz(Q[3], 0.38, 0.30, 2.1e11, 0.28);
  for i in 1:3 loop
    slope[i] = Contact.creepFactor(0.38, 0.30, 2.1e11, 0.28)*4*Q[i]^(2/3)/3.14159265358979;
  end for;
  error = max({
    abs(a1/a_exact[1] - 1), abs(a2/a_exact[2] - 1), abs(a3/a_exact[3] - 1),
    abs(b1/b_exact[1] - 1), abs(b2/b_exact[2] - 1), abs(b3/b_exact[3] - 1),
    abs(slope[1]/slope_exact[1] - 1), abs(slope[2]/slope_exact[2] - 1), abs(slope[3]/slope_exact[3] - 1)});
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>Wheel radius 0.38 m, rail head 0.30 m. The table has three digits.</p>
</html>"));
end HertzTable;
