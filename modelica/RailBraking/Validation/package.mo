within RailBraking;
package Validation "Small models with a known closed-form solution"
  annotation (Documentation(info="<html>
<p>
Each model computes its deviation from a closed form as <code>error</code> and stops with a message
if it exceeds <code>tolerance</code>.
</p>
</html>"));
end Validation;
