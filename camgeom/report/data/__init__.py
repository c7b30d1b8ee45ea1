"""The sections of result.json, from a model's facts in the units of the edge: geometry, load, what is solved."""
