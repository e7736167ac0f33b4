within Features;
model StickSlip "A block on a belt is stopped by dry friction, held, and torn loose by a rising pull"
  parameter Real m = 2;
  parameter Real F_friction = 3;
  parameter Real ramp = 1;
  Real s(start=0, fixed=true);
  Real v(start=1.5, fixed=true);
  Boolean stuck(start=false, fixed=true);
  Real pull;
equation
  pull = max(0, ramp*(time - 2));
  der(s) = v;
  der(v) = if stuck then 0 else (pull - F_friction)/m;
  stuck = not stuck_free and (v <= 0 or pre(stuck));
  when v <= 0 then
    reinit(v, 0);
  end when;
protected
  Boolean stuck_free = pull > F_friction;
end StickSlip;
