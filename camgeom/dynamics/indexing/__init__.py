"""The elastic indexing drive from motor to load: modes, response, energy."""
