within RailBraking;
package Data "Records: parameters that parts of one kind share, and signals that they give"
  annotation (Documentation(info="<html>
<p>
A record reaches every part that takes it by one binding, <code>creep=creep</code>. Where its own fields are to be
bound, bind the whole record to its constructor, <code>final parameter Data.Creep creep = Data.Creep(k_A=k_A,
...)</code>: rumoca 0.10 takes fields that are modified at a record's declaration for numbers when the record is
handed on.
</p>
<p>
<a href=\"modelica://RailBraking.Data.GroupSignals\">GroupSignals</a>, <a
href=\"modelica://RailBraking.Data.WheelsetSignals\">WheelsetSignals</a> and <a
href=\"modelica://RailBraking.Data.Totals\">Totals</a> are given by axles and handed on by bogies, cars and trains. Hand
them on with <code>connect</code> in a component of which there may be an array: rumoca 0.10 refuses equations between
whole records there (\"wrong DAE coordinate role\").
</p>
</html>"));
end Data;
