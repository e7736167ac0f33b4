"""The roller-rig tests of Schwarz and Keck (2020), §4: `study` judges their filter and ours, `figures` draws them."""
