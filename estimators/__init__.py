"""What we believe about the train: adhesion and pad friction estimated from what the sensors show."""
