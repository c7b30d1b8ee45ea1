"""Many models: studies, and the choice of sizes from a requirement."""
