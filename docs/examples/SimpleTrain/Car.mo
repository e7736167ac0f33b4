within SimpleTrain;
block Car "A car of four wheelsets"
  extends Train(final n=4, wheelsets_per_group={1, 1, 1, 1});
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://SimpleTrain.Train\">Train</a>.</p>
</html>"));
end Car;
