within RailBraking.Examples;
model InstrumentedCar "The instrumented car runs over a sine in the alignment"
  extends Icons.Example;
  Plants.MultiPurposeVehicle car(speed_set=17.88, k_A=0.3, k_S=0.1) "Car on wet rail"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
protected
  constant Types.Length way[4] = {0, 2.1, 14.2, 16.3} "Distance of each wheelset behind the first";
equation
  for i in 1:4 loop
    car.alignment[i] = 2e-3*sin(2*3.14159265358979*(17.88*time - way[i])/25);
  end for;
  car.vertical = zeros(4);
  car.cross_level = zeros(4);
  car.gauge = zeros(4);
  car.mu0 = fill(0.2, 4);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=10, Tolerance=1e-6, Interval=0.005),
    Documentation(info="<html>
<p>
Wavelength 25 m, amplitude 2 mm: the wheelsets follow the rails and yaw, which accelerates their axle boxes along the
track.
</p>
</html>"));
end InstrumentedCar;
