within Features;
model Conditional "Conditional components and connectors"
  connector In = input Real;
  connector Out = output Real;
  model Fed
    parameter Boolean use_u = false;
    parameter Real u_constant = 2;
    In u if use_u;
    In inside;
    Real x(start=0, fixed=true);
  equation
    connect(u, inside);
    if not use_u then
      inside = u_constant;
    end if;
    der(x) = inside - x;
  end Fed;
  model Decay
    Real x(start=1, fixed=true);
  equation
    der(x) = -x;
  end Decay;
  Fed plain;
  Fed driven(use_u=true);
  Decay gone if false;
  Decay here;
  Out source;
equation
  source = sin(time);
  connect(source, driven.u);
end Conditional;
