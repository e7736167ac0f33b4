within RailBraking;
package Validation "Small models whose answer is known in closed form"
  annotation (Documentation(info="<html>
<p>
Each model computes its deviation from a closed form as <code>error</code> and stops with a message when that leaves
<code>tolerance</code>.
A runner has nothing to judge.
</p>
</html>"));
end Validation;
