"""Reading of files: YAML, meshes and textures, with errors that name file, line and rule."""
