within RailBraking.Interfaces;
connector BooleanInput = input Boolean "Boolean signal that comes in";
