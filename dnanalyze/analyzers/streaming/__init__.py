"""One pass over the frames, in threads or on a cluster, and what is kept of it on disk."""
