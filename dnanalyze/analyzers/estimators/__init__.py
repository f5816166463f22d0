"""Numbers from images and sums: quantiles, standard errors, defects, steps, thermal laws."""
