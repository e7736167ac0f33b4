within RailBraking;
package Data "Records of parameters that parts of one kind share"
  annotation (Documentation(info="<html>
<p>
A record reaches every part that takes it by one binding, <code>creep=creep</code>. Where its own fields are to be
bound, bind the whole record to its constructor, <code>final parameter Data.Creep creep = Data.Creep(k_A=k_A,
...)</code>: rumoca 0.10 takes fields that are modified at a record's declaration for numbers when the record is
handed on.
</p>
</html>"));
end Data;
