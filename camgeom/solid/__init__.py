"""What the cam is made of: blanks, recipes of bodies, and closed meshes with a stated error."""
