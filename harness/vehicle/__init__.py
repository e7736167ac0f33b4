"""The vehicle as a value, nominal or true: formation, brakes, plant parameters, running resistance and slip."""
