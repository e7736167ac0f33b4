within RailBraking.Interfaces;
connector BooleanOutput = output Boolean "Boolean signal that comes out";
