"""Data sets made of data sets: without some episodes, in parts, together, of another form; whole or not at all."""
