// Mesa's llvmpipe ends every loop of an invocation once they have gone 65,535 rounds in all,
// and says nothing. Invocations that run in SIMD, 8 or 16 of a workgroup, share these rounds.
// A kernel with long loops asks at its end whether that has happened.
//
// Kernels that follow paths are built in two ways. The plain one counts invocations that were
// ended early; the host then discards what they have done and turns to the other one
// (IS_RESUMABLE, src/render/path_pass.rs). That one asks after every segment. A segment that was ended
// early does not count: the invocation keeps the path as it was before it and is UNFINISHED,
// and another dispatch (`resumed`) goes on with all rounds there are. If the dispatch has not
// finished a single segment, it is STUCK, and is given a workgroup to itself: of `spread`
// invocations only one works. A path whose segment needs too many rounds even then is cut. So
// what becomes of a path depends neither on its neighbours nor on the size of dispatches.

// Whether loops no longer go round. `two` is 2, but a compiler must not know it.
bool interrupted(uint two) {
    uint rounds = 0u;
    for (uint i = 0u; i < two; i++) {
        rounds++;
    }
    return rounds < two;
}

// What is next for an invocation that follows paths.
export const uint FINISHED = 0u;   // nothing
export const uint UNFINISHED = 1u; // another dispatch
export const uint STUCK = 2u;      // a dispatch in which it is alone in its workgroup
