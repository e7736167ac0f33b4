within RailBraking.UsersGuide;
class BuildingTrains "How to compose a train"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>
A train is composed of the following components; forces and torques are transmitted by connectors, everything else is a
signal:
</p>
<table border=\"1\" cellspacing=\"0\" cellpadding=\"2\">
<tr><td><a href=\"modelica://RailBraking.Components.Axle\">Axle</a></td>
<td>one wheelset with its brake, or several that shafts couple; <code>shaft</code> for a drive</td></tr>
<tr><td><a href=\"modelica://RailBraking.Components.Bogie\">Bogie</a></td>
<td>n wheelsets under a frame on its primary suspension; <code>pivot</code> to a car body</td></tr>
<tr><td><a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a></td>
<td>mass and drag; <code>front</code>, <code>rear</code> to couplers, <code>pivot</code> to bogies</td></tr>
<tr><td><a href=\"modelica://RailBraking.Vehicles.Car\">Car</a></td><td>a body on equal bogies</td></tr>
<tr><td><a href=\"modelica://RailBraking.Components.Coupler\">Coupler</a></td>
<td>spring, damper and slack between two cars; stiff and without slack it is a bar</td></tr>
<tr><td><a href=\"modelica://RailBraking.Components.Rest\">Rest</a></td><td>detection of standstill</td></tr>
</table>
<p>
<a href=\"modelica://RailBraking.Vehicles.PartialTrain\">PartialTrain</a> has the parameters, inputs
and outputs of the loop and the sums over the train. An axle outputs its signals as one record,
<code>group</code>; bogie and car pass it on with the records of their wheelsets, and a train
assigns them: <code>group[2:3] = jacobs.group;
wheelset[3:4] = jacobs.wheelset;</code>. <a
href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a> adds any number of equal cars; <a
href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a> is an example
with different bogies under a body, including a Jacobs bogie.
</p>
<h4>Shared valves</h4>
<p>
Cylinders and riggings belong to the train, not to the axle: connect the pressure of one cylinder with the rigging of
one group, of all groups of a bogie or of all of a car, and give it the volume of all of them.
</p>
<h4>Other parts</h4>
<p>
The laws of contacts and pads, the shafts between wheels and brake discs, and the height of the rail are replaceable at
every level, under a different name at each level: <code>Bogie
leading(redeclare block BogieContact = MyContact, redeclare block BogiePad = MyPads)</code>, <code>AxleContact</code>
in an axle, <code>CarContact</code> in a car, <code>TrainContact</code> in a train of <code>Plants</code>. A contact
extends <a
href=\"modelica://RailBraking.Interfaces.PartialContact\">PartialContact</a>, a pad <a
href=\"modelica://RailBraking.Interfaces.PartialPadFriction\">PartialPadFriction</a>, a shaft (<code>BogieShaft</code>
and so on) <a href=\"modelica://RailBraking.Interfaces.PartialShaft\">PartialShaft</a>, a rail
(<code>BogieRail</code>) <a href=\"modelica://RailBraking.Interfaces.PartialRail\">PartialRail</a>. Do not
redeclare through several levels, as in <code>leading(axle(redeclare block AxleContact =
MyContact))</code>: the built-in compiler rejects that.
</p>
<h4>Limitations</h4>
<p>
Cars that are joined rigidly are one body with the bogies of all; use a stiff coupler between two
bodies to obtain the force between them.
</p>
</html>"));
end BuildingTrains;
