within RailBraking.Validation;
model BlockLaws "Friction of blocks of cast iron and of composite K settles at the published laws"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  constant Types.Ratio nominal = 0.024*(30e3 + 62.5e3)/(30e3 + 12.5e3)*(30 + 100)/(30 + 20)
    "Cast iron P6 at 30 kN and 30 km/h";
  constant Types.Ratio steady = 0.024*(20e3 + 62.5e3)/(20e3 + 12.5e3)*(60 + 100)/(60 + 20)
    "Cast iron P6 at 20 kN and 60 km/h";
  constant Types.Ratio steady_composite = 0.055*(20e3 + 200e3)/(20e3 + 50e3)*(60 + 150)/(60 + 75)
    "Composite K at 20 kN and 60 km/h";
  Friction.BlockFriction iron(mu_nominal=nominal, mu_start=0.10, pad_speed_nominal=30/3.6, pad_force_nominal=30e3)
    "One block of cast iron P6";
  Components.TreadBrake composite(n_units=1, r_friction=0.46, pad(
    mu_nominal=steady_composite, mu_start=steady_composite, pad_speed_nominal=60/3.6,
    pad_force_nominal=80e3, F_upper=4*200e3, F_lower=4*50e3, v_upper=150/3.6, v_lower=75/3.6))
    "Four composite blocks at their nominal speed and force";
equation
  iron.pad_force = 20e3;
  iron.pad_speed = 60/3.6;
  iron.temperature = 600;
  composite.pad_force = 80e3;
  composite.w = 60/3.6/0.46;
  composite.speed = 60/3.6;
  error = abs(iron.mu - steady - (0.10 - steady)*exp(-sqrt(1/9 + (20e3*60/3.6/2e5)^2)*20e3^4/(20e3^4 + 1e3^4)*time))
    + abs(composite.torque/(80e3*0.46) - steady_composite);
  annotation (
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The nominal point has no effect on the law, and four blocks under four times the force have the friction of one.
</p>
</html>"));
end BlockLaws;
