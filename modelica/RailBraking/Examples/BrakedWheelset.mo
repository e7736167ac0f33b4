within RailBraking.Examples;
model BrakedWheelset "One braked wheelset under a mass, put together from components"
  parameter Types.Mass m = 14500 "Mass on the wheelset";
  Pneumatics.PrescribedPressure cylinder(p_max=2e5, V=6e-3) "Cylinder with a measured pressure";
  Pneumatics.Rigging rigging(A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200) "Rigging";
  Components.GroupBrake brake(n_units=2, r_friction=0.22) "Two brake units";
  Components.Wheelsets wheelset(J=209, r=0.38, k_A=wet.k_A, k_S=wet.k_S, A=wet.A, B=wet.B, w_start=20/0.38) "Wheelset";
  Components.TrainBody body(m=m, c_drag=0, v_start=20) "Mass along the track";
  parameter Contact.Surfaces.Wet wet "Rail";
equation
  cylinder.command = 2e5*tanh(time);
  rigging.pressure = cylinder.pressure;
  brake.pad_force = rigging.pad_force;
  brake.w = wheelset.w;
  brake.speed = body.v;
  wheelset.brake_torque = brake.torque;
  wheelset.v = body.v;
  wheelset.load[1] = m*g;
  wheelset.mu0[1] = wet.mu0;
  wheelset.standstill = body.standstill;
  body.F = wheelset.F[1];
  body.track_force = 0;
  body.capacity = wheelset.capacity;
  annotation (
    experiment(StopTime=30, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>A pattern for other vehicles: equations join inputs to outputs, the body owns the speed, wheelsets own their
rotation.</p>
</html>"));
end BrakedWheelset;
