within RailBraking.UsersGuide;
class ReleaseNotes "Release notes"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<h4>Version 0.2.0</h4>
<ul>
<li>Gradients and curves act on each wheelset: <code>Vehicles.PartialConsist</code> has the further input
<code>car_track_force</code>.</li>
<li><code>LateralLiteral</code> is <code>LateralReconstruction</code>.</li>
<li><code>Contact.HeatedContact</code> and <code>Contact.CleaningContact</code>: friction that falls with the
temperature of the contact, and a film that its slip removes. Two-part train and wagon have
<code>TrainContact</code>.</li>
<li><code>Contact.SimplifiedContact</code>: contact forces by Kalker's simplified theory. <code>AxleShaft</code>,
<code>BogieShaft</code> and so on: <code>Components.ElasticShaft</code> twists between wheels and brake discs.
<code>BogieRail</code> and so on: <code>Tracks.UnevenRail</code> moves the wheelsets up and down. Riggings extend
<code>Interfaces.PartialRigging</code>; <code>Pneumatics.HystereticRigging</code> has no input for the rate of the
pressure any more, and friction of the seal's preload, <code>p_seal</code>.</li>
</ul>
<h4>Version 0.1.0</h4>
<ul>
<li>Two-part train with ideal cylinders or valves, and its prediction models.</li>
<li>Wagon, roller rig, wheelset with lateral motion and instrumented car.</li>
<li>Plants say which of their wheelsets turn as one: <code>wheelsets_per_group</code>, and where they are:
<code>wheelsets_per_car</code>, <code>wheelset_position</code>.</li>
<li>Physics of all vehicles in <code>Vehicles</code>; blocks of <code>Plants</code> add the actuation.</li>
<li><code>FMUs</code> is divided into <code>Plants</code>, <code>Predictions</code> and <code>FMUs</code>; names of
classes stay: <code>FMUs.TwoPartTrain</code> is <code>Plants.TwoPartTrain</code>.</li>
<li>Brake equipment with air ports: brake pipe, driver's brake valve, distributor, reservoir, compressor, load
valve;
electropneumatic command, electrodynamic brake with blending, magnetic track brake,
isolation and parking of one unit.</li>
<li><code>curve</code> of axles, bogies, cars, trains and the wagon: the shape of the creep curve at each wheelset,
which may be bound to inputs; <code>Data.CreepCurve</code>.</li>
<li><code>Pneumatics.BrakePipe</code> carries momentum with the air and converges with its cells. Through a locomotive
and ten coaches whose branches hold 3 l the front of an emergency brake runs at 249 m/s, just below the 250 m/s of UIC
540, without branches at 266 m/s; branch volume and friction factor are estimates, so the model does not show that such
a train keeps the limit.</li>
<li>Axles, bogies and cars give records, <code>group</code>, <code>wheelset</code> and <code>totals</code>, in place of
an output for each quantity: <code>bogie.group.slip</code> for <code>bogie.slip</code>,
<code>bogie.totals.capacity</code> for <code>bogie.capacity</code>. Outputs of FMUs keep their names.</li>
<li>Icons, and places for all components in diagrams.</li>
</ul>
</html>"));
end ReleaseNotes;
