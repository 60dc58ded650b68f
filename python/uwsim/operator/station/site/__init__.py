"""What a browser fetches by HTTP: the page's files, maps, pictures, downloads."""
