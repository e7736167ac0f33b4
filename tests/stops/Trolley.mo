package Trolley "A track trolley of another house: three axles, the leading two coupled, names and units of its own"
  function grip "Friction used at a given creep"
    input Real creep "Relative creep, positive when braking";
    input Real most "Friction at the peak";
    output Real used "Friction used";
  algorithm
    used := most*sin(1.5*atan(1.7320508075688772*creep/0.06));
    annotation (smoothOrder=100, Inline=true);
  end grip;

  block Vehicle "Point mass on three axles"
    parameter Real tare(final unit="t", min=1) = 24 "Mass";
    parameter Real v0(final unit="km/h", min=0) = 60 "Speed at the start";
    input Real air[2](each final unit="bar", each start=0) "Pressure asked of front and rear cylinders";
    input Real rail[3](each final unit="%", each start=10) "Friction of the rail under each axle";
    output Real v_kmh(final unit="km/h") = 3.6*v "Speed";
    output Real way(final unit="km") = s/1000 "Way since the start";
    output Real braking(final unit="m/s2") = -der(v) "Retardation";
    output Real turns[2](each final unit="rev/min") = 9.549296585513721*w "Speed of rotation of front and rear axles";
    output Real cylinder[2](each final unit="bar") = p "Pressure in front and rear cylinders";
    output Real used[3](each final unit="%") = {100*u[1], 100*u[1], 100*u[2]} "Friction used at each axle";
    output Real slide[2](each final unit="%") = 100*creep "Creep of front and rear axles";
    Real s(final unit="m", start=0, fixed=true) "Way";
    Real v(final unit="m/s", start=v0/3.6, fixed=true) "Speed";
    Real w[2](each final unit="rad/s", each start=v0/3.6/0.4, each fixed=true) "Angular velocities";
    Real p[2](each final unit="bar", each start=0, each fixed=true) "Pressures";
  protected
    Real creep[2] "Creep of front and rear axles";
    Real u[2] "Friction used";
    Real force[2](each final unit="kN") "Force of the rail on front and rear axles";
  equation
    der(s) = v;
    tare*der(v) = -force[1] - force[2];
    for i in 1:2 loop
      0.1*der(p[i]) = air[i] - p[i];
      creep[i] = (v - 0.4*w[i])/sqrt(v^2 + 0.09);
    end for;
    u = {(grip(creep[1], rail[1]/100) + grip(creep[1], rail[2]/100))/2, grip(creep[2], rail[3]/100)};
    force = {2*tare*9.81/3*u[1], tare*9.81/3*u[2]};
    200*der(w[1]) = 1000*(0.4*force[1] - 6*p[1]*tanh(w[1]/0.3));
    100*der(w[2]) = 1000*(0.4*force[2] - 3*p[2]*tanh(w[2]/0.3));
  end Vehicle;
end Trolley;
