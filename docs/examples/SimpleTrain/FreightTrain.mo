within SimpleTrain;
block FreightTrain "A train of sixteen wheelsets"
  extends Train(final n=16, wheelsets_per_group={1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1});
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://SimpleTrain.Train\">Train</a>.</p>
</html>"));
end FreightTrain;
