within RailBraking.UsersGuide;
class BuildingTrains "How to put a train together"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>A train is made of these parts; forces and torques go through connectors, everything else is a signal:</p>
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
<tr><td><a href=\"modelica://RailBraking.Components.Rest\">Rest</a></td><td>when the train stands</td></tr>
</table>
<p>
<a href=\"modelica://RailBraking.Vehicles.PartialTrain\">PartialTrain</a> has the parameters, inputs and outputs that
the loop knows and the sums over the train. An axle gives its signals as one record, <code>group</code>; bogie and car
hand it on with the records of their wheelsets, and a train says which are its own: <code>group[2:3] = jacobs.group;
wheelset[3:4] = jacobs.wheelset;</code>. <a
href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a> adds any number of equal cars; <a
href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a> shows how bogies that
differ are put under a body, a Jacobs bogie among them.
</p>
<h4>Who shares a valve</h4>
<p>
Cylinders and riggings belong to the train, not to the axle: connect the pressure of one cylinder with the rigging of
one group, of all groups of a bogie or of all of a car, and give it the volume of all of them.
</p>
<h4>Other parts</h4>
<p>
The laws of contacts and pads are replaceable at every level, under names of their own, for what is below: <code>Bogie
leading(redeclare block BogieContact = MyContact, redeclare block BogiePad = MyPads)</code>, <code>AxleContact</code>
in an axle, <code>CarContact</code> in a car, <code>TrainContact</code> in a train of <code>Plants</code>. A contact
extends <a
href=\"modelica://RailBraking.Interfaces.PartialContact\">PartialContact</a>, a pad <a
href=\"modelica://RailBraking.Interfaces.PartialPadFriction\">PartialPadFriction</a>. Do not reach down through the
parts, as in <code>leading(axle(redeclare block AxleContact = MyContact))</code>: the built-in compiler refuses that.
</p>
<h4>Limitations</h4>
<p>
Cars that are joined without any give are one body with the bogies of all; a stiff coupler between two bodies gives
the force between them.
</p>
</html>"));
end BuildingTrains;
