"""Control loops and pose estimation; both see vehicles only through protocols."""
