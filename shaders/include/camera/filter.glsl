// The pixel filter has negative lobes, and so has the radiance that an iteration adds.
layout(constant_id = 66) const bool HAS_SIGNED_FILTER = false;
