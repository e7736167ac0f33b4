within RailBraking;
package Vehicles "Trains made of components"
  annotation (Documentation(info="<html>
<p>
The two-part train is a diesel multiple unit of the axle formula B'(2)B': two motor bogies whose wheelsets are coupled
and a Jacobs trailer bogie between the car bodies. Wheelsets 1 to 6 count from the leading end; groups that turn on
their own are 1 (wheelsets 1 and 2), 2 (3), 3 (4) and 4 (5 and 6).
</p>
</html>"));
end Vehicles;
