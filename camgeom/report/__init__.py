"""One page about a model, its pictures and films, and the result that scripts read."""
