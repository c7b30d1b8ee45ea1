"""The cam's body as a volume: meshes of swept hexahedra, the contact's load on them, and linear elasticity.

Rooms: `volume` (what is handed over), `ring` (the mesh), `section` and `plate` (its cross-sections), `hexes` (blocks),
`frame` (a frame's plate of them), `load`, `element` (the 20-node hexahedron), `solver`, `sparse_solver`, `stress` at
roots, `frame_stress`, `compliance` below contacts.
"""
