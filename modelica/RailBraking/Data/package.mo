within RailBraking;
package Data "Records: parameters that components of one kind share, and their signals"
  annotation (Documentation(info="<html>
<p>
A record is passed to a component by one binding, <code>creep=creep</code>. To bind its fields, bind
the whole record to its constructor, <code>final parameter Data.Creep creep = Data.Creep(k_A=k_A,
...)</code>: rumoca 0.10 treats fields that are modified in a record's declaration as numbers when
the record is passed on.
</p>
<p>
<a href=\"modelica://RailBraking.Data.GroupSignals\">GroupSignals</a>, <a
href=\"modelica://RailBraking.Data.WheelsetSignals\">WheelsetSignals</a> and <a
href=\"modelica://RailBraking.Data.Totals\">Totals</a> are outputs of axles, which bogies, cars and
trains pass on. In a component that may be in an array, pass them on with <code>connect</code>:
rumoca 0.10 rejects equations between whole records there (\"wrong DAE coordinate role\").
</p>
</html>"));
end Data;
