"""The roller-rig tests of Schwarz and Keck (2020), §4: their filter and ours, judged against the truth."""
