// Radiance is negative where the pixel filter is.
layout(constant_id = 66) const bool HAS_SIGNED_FILTER = false;
