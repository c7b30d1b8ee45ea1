"""Linear systems with periodic coefficients: one-step methods, steady states, peaks."""
