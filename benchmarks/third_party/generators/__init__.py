"""Who makes the frames; one file each."""
