"""One question answered by a class: what is asked, a result handed in, all of them together."""
