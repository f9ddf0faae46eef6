"""Parts of pictures that several figures share."""
