within RailBraking.Interfaces;
connector RealInput = input Real "Real signal that comes in";
