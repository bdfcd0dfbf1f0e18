// The number of photons in the flux of each pixel.
UPDATED_BUFFER(uint, flux_counts)
