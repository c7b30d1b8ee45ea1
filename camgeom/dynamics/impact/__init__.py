"""A follower in its clearance: contact, free flight and impact between two opposing flanks."""
