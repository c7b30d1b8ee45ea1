"""The best motion law for a requirement, with the bound that no law of its class can beat: `best.best`, `wish.Wish`."""
