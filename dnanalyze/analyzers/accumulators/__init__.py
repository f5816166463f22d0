"""What is kept of the frames of a setting: sums that merge, of pixels, codes and neighbours."""
