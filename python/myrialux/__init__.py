"""Pages and perceptual measures for Myrialux; the program runs this package, and it can be imported as well."""
