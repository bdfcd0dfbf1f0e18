// What rough points have gathered: sums per pixel, in the units of flux.glsl, of photons' weights times the BSDF, the eye
// path's throughput and a factor for the area of the disc (gather_rough.comp). They are two's complements, since the
// throughput has the sign of the pixel filter.
#include "lookup/flux.glsl"
#include "lookup/flux_sums.glsl"
