"""HTML pages of pictures, error maps, plots and tables in one file each, which open without a network."""
