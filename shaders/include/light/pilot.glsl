// Marks the photons of a pilot, so that the host knows which photon a record is of, and which records an iteration would
// not have. The marks are in PhotonRecord.cell.
#include "scene/features.glsl"

export const uint PILOT_DIRECT = 0x80000000u; // the record is of a first surface, whose direct light eye paths sample

uint pilot_mark(uint photon, uint depth) {
    if (DIRECT_NEE) {
        return photon | (depth == 0u ? PILOT_DIRECT : 0u);
    }
    return photon;
}
