"""Control loops and pose estimation; both access vehicles only through protocols."""
