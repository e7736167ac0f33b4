"""What is known of the pressure transducers."""

PRESSURE_OFFSET = 5e3
"""1σ of the offset of a cylinder's pressure transducer [Pa]: 0.5 % of 10 bar full scale, the class of the sensors in
`table1.toml`. It belongs to the transducer, so it is taken to be the same in every stop."""
