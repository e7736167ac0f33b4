within RailBraking.Examples;
model BrakedWheelset "One braked wheelset under a mass, composed of components"
  extends Icons.Example;
  parameter Types.Mass m = 14500 "Mass on the wheelset";
  Pneumatics.PrescribedPressure cylinder(p_max=2e5, V=6e-3) "Cylinder with a measured pressure"
    annotation(Placement(transformation(extent={{-73, 20}, {-33, 60}})));
  Pneumatics.Rigging rigging(A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200) "Rigging"
    annotation(Placement(transformation(extent={{-20, 20}, {20, 60}})));
  Components.GroupBrake brake(n_units=2, r_friction=0.22) "Two brake units"
    annotation(Placement(transformation(extent={{33, 20}, {73, 60}})));
  Components.Wheelsets wheelset(
    J=209, r=0.38, curve={Data.CreepCurve(k_A=wet.k_A, k_S=wet.k_S, A=wet.A, B=wet.B)}, w_start=20/0.38) "Wheelset"
    annotation(Placement(transformation(extent={{-73, -60}, {-33, -20}})));
  Components.TrainBody body(m=m, c_drag=0, start_speed=20) "Mass along the track"
    annotation(Placement(transformation(extent={{-20, -60}, {20, -20}})));
  parameter Contact.Surfaces.Wet wet "Rail"
    annotation(Placement(transformation(extent={{33, -60}, {73, -20}})));
equation
  cylinder.command = 2e5*tanh(time);
  connect(cylinder.pressure, rigging.pressure)
    annotation(Line(points={{-33, 40}, {-27, 40}, {-27, 40}, {-20, 40}}, color={0, 0, 127}));
  connect(rigging.pad_force, brake.pad_force)
    annotation(Line(points={{20, 40}, {26, 40}, {26, 40}, {33, 40}}, color={0, 0, 127}));
  brake.w = wheelset.w;
  brake.speed = body.v;
  connect(brake.torque, wheelset.brake_torque)
    annotation(Line(points={{73, 40}, {0, 40}, {0, -40}, {-73, -40}}, color={0, 0, 127}));
  wheelset.v = body.v;
  wheelset.load[1] = m*g;
  wheelset.mu0[1] = wet.mu0;
  wheelset.standstill = body.standstill;
  body.F = wheelset.F[1];
  body.track_force = 0;
  connect(wheelset.capacity, body.capacity)
    annotation(Line(points={{-33, -40}, {-27, -40}, {-27, -40}, {-20, -40}}, color={0, 0, 127}));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=30, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>A pattern for other vehicles: equations connect inputs with outputs, the speed is a state of the
body, and rotation is a state of each wheelset.</p>
</html>"));
end BrakedWheelset;
