"""The site that a browser fetches by HTTP: the files of the page, maps, pictures, downloads."""
