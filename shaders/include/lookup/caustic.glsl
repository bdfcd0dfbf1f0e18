// Marks the photons of caustics: those that came from their light by specular or rough surfaces only, at least
// one of them. The mark is a bit of PhotonRecord.cell that cell_mark leaves free.
#include "lookup/records.glsl"
#include "scene/features.glsl"

const uint CAUSTIC_MARK = 0x80000000u;

uint caustic_mark(bool is_caustic) {
    if (HAS_CAUSTIC_LAYER) {
        return is_caustic ? CAUSTIC_MARK : 0u;
    }
    return 0u;
}

// The mark of a cell of the hash grid, of a photon that is sorted into it.
uint marked_cell(PhotonRecord photon, uint cell) {
    if (HAS_CAUSTIC_LAYER) {
        return cell | (photon.cell & CAUSTIC_MARK);
    }
    return cell;
}

// The cell_mark of a photon.
uint cell_of_record(PhotonRecord photon) {
    if (HAS_CAUSTIC_LAYER) {
        return photon.cell & ~CAUSTIC_MARK;
    }
    return photon.cell;
}

// Whether a pass gathers a photon.
bool is_gathered(PhotonRecord photon) {
    if (GATHERS_CAUSTICS) {
        return (photon.cell & CAUSTIC_MARK) != 0u;
    }
    return true;
}
