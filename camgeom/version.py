"""The version: below all that writes it into files, so that nothing within imports the package itself."""

__version__ = "0.1.0"
