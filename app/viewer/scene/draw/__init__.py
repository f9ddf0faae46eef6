"""What marks are drawn with: meshes, colours, attitudes, the display's units."""
