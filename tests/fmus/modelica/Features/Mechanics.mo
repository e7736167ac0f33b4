within Features;
model Mechanics "Connectors with flow, a gear that demands index reduction, stops with events"
  connector Flange
    Real phi;
    flow Real tau;
  end Flange;
  model Inertia
    Flange a;
    Flange b;
    parameter Real J = 1;
    Real phi(start=0, fixed=true);
    Real w(start=0, fixed=true);
  equation
    phi = a.phi;
    a.phi = b.phi;
    der(phi) = w;
    J*der(w) = a.tau + b.tau;
  end Inertia;
  model Load
    Flange a;
    parameter Real J = 3;
    Real phi;
    Real w;
  equation
    phi = a.phi;
    der(phi) = w;
    J*der(w) = a.tau;
  end Load;
  model Gear
    Flange a;
    Flange b;
    parameter Real ratio = 2;
  equation
    a.phi = ratio*b.phi;
    0 = ratio*a.tau + b.tau;
  end Gear;
  model Torque
    Flange a;
    input Real tau;
  equation
    a.tau = -tau;
  end Torque;
  model Stop "Spring that hardens at its ends"
    Flange a;
    Flange b;
    parameter Real c = 100;
    Real rel;
  equation
    rel = b.phi - a.phi;
    b.tau = if rel > 0.05 then c*rel + 10*c*(rel - 0.05) elseif rel < -0.05 then c*rel + 10*c*(rel + 0.05) else c*rel;
    a.tau = -b.tau;
  end Stop;
  Torque torque(tau=10*sin(3*time) - 0.5*motor.w);
  Inertia motor(J=2);
  Stop stop;
  Inertia shaft(J=0.5);
  Gear gear;
  Load load;
  output Real y;
equation
  connect(torque.a, motor.a);
  connect(motor.b, stop.a);
  connect(stop.b, shaft.a);
  connect(shaft.b, gear.a);
  connect(gear.b, load.a);
  y = load.w;
end Mechanics;
