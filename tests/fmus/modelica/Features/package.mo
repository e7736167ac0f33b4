package Features "One small model for each language feature the compiler must get right"
end Features;
