"""Motion of what is not rigid: elastic followers, indexing drives, impacts; SI units."""
