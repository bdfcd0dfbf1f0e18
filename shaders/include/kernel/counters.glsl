// What kernels count.

// Events since the counters were last cleared. Each photon path ends in one of five ways.
struct Counters {
    uint recorded;      // photons stored for the gather pass
    uint emitted;       // photon paths begun
    uint deposited;     // ended: absorbed where photons are stored
    uint absorbed;      // ended: absorbed at a specular surface, in a medium or at emission
    uint escaped;       // ended: left the scene
    uint truncated;     // ended: reached the maximum depth
    uint lost_in_glass; // ended: found no way out of a dielectric
    uint eye_lost_in_glass; // eye paths that found no way out of a dielectric
    uint immersed;      // photon and eye paths that met something opaque in a dielectric
    uint non_finite;    // paths and pixels dropped for a value that is not finite
    uint saturated;     // sums and terms of sums that would not fit
    uint interrupted;   // invocations that the driver ended before they were done
    uint unfinished;    // invocations that wait for another dispatch
    uint stuck;         // invocations that wait for a dispatch in which they are alone
    uint cut;           // paths ended because the driver cannot follow them
    uint recorded_rough; // photons stored for the pass that gathers on rough surfaces
};

// All invocations add to them.
UPDATED_VALUE(Counters, counters)
