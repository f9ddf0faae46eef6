"""A flock as a program of its own, compiled for a web page: the same kernels as WebAssembly."""
