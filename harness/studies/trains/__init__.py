"""The trains of this project against published stops, a calculation by hand, UIC 540, and a trial of sanders."""
