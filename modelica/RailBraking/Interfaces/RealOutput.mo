within RailBraking.Interfaces;
connector RealOutput = output Real "Real signal that comes out";
