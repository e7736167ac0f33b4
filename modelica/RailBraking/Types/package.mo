within RailBraking;
package Types "Quantities with their SI units"
  type Ratio = Real(final unit="1") "Pure number";
  type Time = Real(final quantity="Time", final unit="s") "Time";
  type Length = Real(final quantity="Length", final unit="m") "Length, distance, radius";
  type Area = Real(final quantity="Area", final unit="m2") "Area";
  type Volume = Real(final quantity="Volume", final unit="m3") "Volume";
  type VolumeFlow = Real(final quantity="VolumeFlowRate", final unit="m3/s") "Volume a time";
  type Velocity = Real(final quantity="Velocity", final unit="m/s") "Speed";
  type InverseVelocity = Real(final unit="s/m") "Reciprocal of a speed";
  type Acceleration = Real(final quantity="Acceleration", final unit="m/s2") "Acceleration";
  type Angle = Real(final quantity="Angle", final unit="rad") "Angle";
  type Frequency = Real(final quantity="Frequency", final unit="Hz", min=0) "Frequency";
  type AngularVelocity = Real(final quantity="AngularVelocity", final unit="rad/s") "Angular velocity";
  type AngularAcceleration = Real(final quantity="AngularAcceleration", final unit="rad/s2") "Angular acceleration";
  type Mass = Real(final quantity="Mass", final unit="kg", min=0) "Mass";
  type Inertia = Real(final quantity="MomentOfInertia", final unit="kg.m2", min=0) "Moment of inertia";
  type Density = Real(final quantity="Density", final unit="kg/m3", min=0) "Density";
  type Force = Real(final quantity="Force", final unit="N") "Force";
  type Torque = Real(final quantity="Torque", final unit="N.m") "Torque";
  type Stiffness = Real(final unit="N/m", min=0) "Translational stiffness";
  type RotationalStiffness = Real(final unit="N.m/rad", min=0) "Rotational stiffness";
  type RotationalDamping = Real(final unit="N.m.s/rad", min=0) "Rotational damping";
  type Damping = Real(final unit="N.s/m", min=0) "Translational damping";
  type Modulus = Real(final quantity="Pressure", final unit="Pa", min=0) "Modulus of elasticity";
  type Pressure = Real(final quantity="Pressure", final unit="Pa", nominal=1e5) "Pressure above the atmosphere";
  type PressureRate = Real(final unit="Pa/s") "Pressure a time";
  type Energy = Real(final quantity="Energy", final unit="J") "Energy, work, heat";
  type Power = Real(final quantity="Power", final unit="W") "Power, heat flow";
  type Temperature = Real(final quantity="ThermodynamicTemperature", final unit="K", min=0, nominal=300)
    "Absolute temperature";
  type TemperatureDifference = Real(final quantity="ThermodynamicTemperature", final unit="K")
    "Difference of temperatures";
  type SpecificHeat = Real(final unit="J/(kg.K)", min=0) "Specific heat capacity";
  type HeatConductance = Real(final unit="W/K", min=0) "Heat flow a kelvin";
  type SpeedHeatConductance = Real(final unit="W.s/(K.m)", min=0) "Heat conductance a speed";
  type HeatConductivity = Real(final unit="W/(m.K)", min=0) "Heat flow an area and a gradient of temperature";
  type ThermalResistance = Real(final unit="K/W", min=0) "Rise of temperature a heat flow";
  type TemperatureCoefficient = Real(final unit="1/K") "Relative change a kelvin";
  type RemovalRate = Real(final unit="m/J", min=0) "Share of a film removed an energy on a length";
  type LineEnergy = Real(final unit="J/m") "Energy a length";
  type Curvature = Real(final unit="1/m") "Reciprocal of a radius";
  annotation (Documentation(info="<html>
<p>
One short definition for each quantity, with the unit fixed. They are in one file because they are
read as a table; every other class of the library has a file of its own.
</p>
</html>"));
end Types;
