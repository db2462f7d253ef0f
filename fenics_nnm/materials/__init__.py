"""Linear elastic materials: laws, orientation, and a small library of alloys."""
